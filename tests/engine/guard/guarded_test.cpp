#include "engine/guard/guarded.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "engine/core/not_realtime.h"
#include "tests/support/error_summary.h"

using namespace tactus;
using Kind = JournalEntry::Kind;

namespace {

/// Puts `level` on every output and remembers the blocks it was given.
class Level final : public BlockProcessor {
 public:
  explicit Level(double level) : level_(level) {}
  Status prepare(const StreamFormat& format) override {
    channels_ = format.out_channels;
    blocks.reserve(10'000);
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    blocks.push_back(io.frames);
    for (int c = 0; c < channels_; ++c)
      for (int n = 0; n < io.frames; ++n) io.out[c][n] = level_;
  }
  std::vector<int> blocks;

 private:
  double level_;
  int channels_ = 0;
};

/// Keeps every entry that is applied.
struct RecordedJournal final : BlockTap {
  void applied(const JournalEntry& entry) noexcept override {
    const NotRealtime allocates;
    entries.push_back(entry);
  }
  void observe(const BlockIo&, std::int64_t) noexcept override {}
  std::vector<JournalEntry> entries;
};

/// Runs `guarded` for `frames` frames in one call and returns the outputs.
std::vector<std::vector<double>> play(Guarded& guarded, int channels, int frames) {
  std::vector<std::vector<double>> out(static_cast<std::size_t>(channels),
                                       std::vector<double>(static_cast<std::size_t>(frames), -99.0));
  std::vector<double*> pointers;
  for (auto& channel : out) pointers.push_back(channel.data());
  guarded.process({nullptr, pointers.data(), frames});
  return out;
}

constexpr DriveLimits kAtOnce{.soft_start = Seconds{0}, .fade_out = Seconds{0}};
const GuardedChannel kDrive{DriveGuard::Kind::Drive, kAtOnce};
const GuardedChannel kAudio{DriveGuard::Kind::Audio, kAtOnce};

}  // namespace

TEST_CASE("guarded: every output passes its guard, named or not", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {{DriveGuard::Kind::Drive, {.ceiling = 0.5}}}};
  REQUIRE(guarded.prepare({.out_channels = 2}));
  Level loud{3.0};
  Guarded unnamed{loud, {}};
  REQUIRE(unnamed.prepare({.out_channels = 1}));
  CHECK(play(guarded, 2, 8)[0] == std::vector<double>(8, 0.5));
  const auto unlisted = play(guarded, 2, 8)[1];
  for (const double sample : unlisted) CHECK(sample <= 16.0 / 24'000);
  // Nobody knows what the second drive is: a soft start of half a second.
  const auto alone = play(unnamed, 1, 8)[0];
  for (const double sample : alone) CHECK(sample <= 3.0 * 8 / 24'000);
  CHECK(guarded.counts(0)[GuardStage::Ceiling] == StageCount{16, 0.5});
  CHECK(guarded.frame() == 16);
}

TEST_CASE("guarded: arm and mute hold from their frame on, and are reported with it", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive, kAudio}, /*armed=*/false};
  RecordedJournal journal;
  guarded.set_tap(&journal);
  REQUIRE(guarded.prepare({.out_channels = 2}));
  REQUIRE(guarded.post({3, Kind::Arm, JournalEntry::kAllChannels, 1.0}));
  REQUIRE(guarded.post({6, Kind::Mute, 0, 1.0}));
  const auto out = play(guarded, 2, 8);
  CHECK(out[0] == std::vector<double>{0, 0, 0, 1, 1, 1, 0, 0});
  CHECK(out[1] == std::vector<double>(8, 1.0));  // audio outputs need no arming

  REQUIRE(guarded.post({JournalEntry::kNow, Kind::Mute, JournalEntry::kAllChannels, 1.0}));
  CHECK(play(guarded, 2, 4)[1] == std::vector<double>(4, 0.0));

  CHECK(journal.entries == std::vector<JournalEntry>{{3, Kind::Arm, JournalEntry::kAllChannels, 1.0},
                                                     {6, Kind::Mute, 0, 1.0},
                                                     {8, Kind::Mute, JournalEntry::kAllChannels, 1.0}});
}

TEST_CASE("guarded: an entry for a later block waits for it", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive}};
  REQUIRE(guarded.prepare({.out_channels = 1}));
  REQUIRE(guarded.post({10, Kind::Mute, 0, 1.0}));
  CHECK(play(guarded, 1, 8)[0] == std::vector<double>(8, 1.0));
  CHECK(play(guarded, 1, 4)[0] == std::vector<double>{1, 1, 0, 0});
}

TEST_CASE("guarded: an unmuted drive that is disarmed stays silent", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive}, /*armed=*/false};
  REQUIRE(guarded.prepare({.out_channels = 1}));
  REQUIRE(guarded.post({0, Kind::Mute, 0, 1.0}));
  REQUIRE(guarded.post({1, Kind::Mute, 0, 0.0}));
  CHECK(play(guarded, 1, 4)[0] == std::vector<double>(4, 0.0));
}

TEST_CASE("guarded: a block reaches the processor uncut, whatever is applied within it", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive}};
  REQUIRE(guarded.prepare({.out_channels = 1}));
  REQUIRE(guarded.post({3, Kind::Mute, 0, 1.0}));
  play(guarded, 1, 100);
  CHECK(level.blocks == std::vector<int>{100});
}

TEST_CASE("guarded: mute, disarm and fade take effect in the next block behind 1e5 pending changes",
          "[core]") {
  const auto kind = GENERATE(Kind::Mute, Kind::Arm, Kind::Fade);
  const bool closing = kind != Kind::Arm;  // the value that closes the guards
  Level level{1.0};
  Guarded guarded{level, {kDrive, kAudio}};
  const auto set = [&](bool on) {
    if (kind == Kind::Mute) guarded.mute(on);
    if (kind == Kind::Arm) guarded.arm(on);
    if (kind == Kind::Fade) guarded.fade(on);
  };
  RecordedJournal journal;
  guarded.set_tap(&journal);
  REQUIRE(guarded.prepare({.out_channels = 2}));
  CHECK(play(guarded, 2, 8)[0] == std::vector<double>(8, 1.0));
  for (int n = 0; n < 100'000; ++n) {
    (void)guarded.post({JournalEntry::kNow, Kind::Arm, JournalEntry::kAllChannels, 1.0});
    (void)guarded.post({1'000'000 + n, Kind::Mute, 0, 0.0});
  }
  set(closing);
  const auto out = play(guarded, 2, 8);
  CHECK(out[0] == std::vector<double>(8, 0.0));
  CHECK(out[1] == std::vector<double>(8, kind == Kind::Arm ? 1.0 : 0.0));

  // Journalled with its frame, so that a take replays.
  CHECK(journal.entries.back() == JournalEntry{8, kind, JournalEntry::kAllChannels, closing ? 1.0 : 0.0});

  set(!closing);
  CHECK(play(guarded, 2, 8)[0] == std::vector<double>(8, 1.0));
}

TEST_CASE("guarded: the last of several settings of a switch counts", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive}};
  REQUIRE(guarded.prepare({.out_channels = 1}));
  guarded.mute(true);
  guarded.mute(false);
  CHECK(play(guarded, 1, 4)[0] == std::vector<double>(4, 1.0));
  guarded.fade(false);
  guarded.fade(true);
  CHECK(play(guarded, 1, 4)[0] == std::vector<double>(4, 0.0));
  REQUIRE(guarded.prepare({.out_channels = 1}));  // a fade outlasts a restart, and a take that begins there
  CHECK(guarded.state() == std::vector<JournalEntry>{{0, Kind::Fade, JournalEntry::kAllChannels, 1.0}});
  guarded.fade(false);
  CHECK(play(guarded, 1, 4)[0] == std::vector<double>(4, 1.0));
}

TEST_CASE("guarded: refuses entries that are not for it, and more than it can hold", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive}};
  CHECK_FALSE(guarded.post({0, Kind::ControlChange, 0, 1.0}));
  int taken = 0;
  while (taken < 10'000 && guarded.post({0, Kind::Mute, 0, 0.0})) ++taken;
  CHECK(taken == 256);
}

TEST_CASE("guarded: prepare says what does not fit", "[core]") {
  Level level{1.0};
  Guarded many{level, {kDrive, kDrive}};
  CHECK(test::summary(many.prepare({.out_channels = 1})) == "BadArgument 2 1");
  Guarded wrong{level, {{DriveGuard::Kind::Drive, {.ceiling = 2.0}}}};
  CHECK(wrong.prepare({.out_channels = 1}).error().code == Errc::OutOfRange);
}

TEST_CASE("guarded: the last block before a stop is zeros, and what follows starts softly", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {{DriveGuard::Kind::Drive, {.soft_start = 1_ms}}}};
  REQUIRE(guarded.prepare({.out_channels = 1}));
  CHECK(play(guarded, 1, 100)[0].back() == 1.0);
  std::vector<double> last(16, -99.0);
  double* out = last.data();
  guarded.finish({nullptr, &out, 16});
  CHECK(last == std::vector<double>(16, 0.0));
  CHECK(guarded.frame() == 100);
  const auto again = play(guarded, 1, 100)[0];
  CHECK(again[0] == 0.0);
  CHECK(again[24] == 0.5);
  CHECK(again[99] == 1.0);
}

TEST_CASE("guarded: a stop comes to zero within the slew limit, in as many blocks as that takes", "[core]") {
  Level level{0.4505};
  Guarded guarded{level, {{DriveGuard::Kind::Drive, {.slew_per_second = 48.0}}, kDrive}};
  REQUIRE(guarded.prepare({.out_channels = 2}));
  CHECK(guarded.closing_time() == Seconds{0.005 + 1.0 / 48.0});
  CHECK(play(guarded, 2, 1000)[0].back() == 0.4505);
  CHECK_FALSE(guarded.silent());
  double before = 0.4505;
  for (int block = 0; block < 5; ++block) {
    std::vector<double> slow(100, -99.0), fast(100, -99.0);
    double* out[] = {slow.data(), fast.data()};
    const bool silent = guarded.finish({nullptr, out, 100});
    CHECK(silent == (block == 4));  // after 451 steps of 0.001
    CHECK(guarded.silent() == silent);
    CHECK(fast == std::vector<double>(100, 0.0));
    for (const double sample : slow) {
      CHECK(sample >= before - 0.001 - 1e-12);
      CHECK(sample <= before);
      before = sample;
    }
  }
  CHECK(before == 0.0);
}

TEST_CASE("guarded: a restart is never cooler than the run before, and keeps that as its state", "[core]") {
  const HeatLimits heat{.watts_at_full_scale = 10, .watts_for_ever = 5, .coil_time = 100_ms};
  const std::vector<GuardedChannel> guards = {kAudio, {DriveGuard::Kind::Drive, {.heat = heat}}};
  Level level{0.6};
  Guarded guarded{level, guards};
  REQUIRE(guarded.prepare({.out_channels = 2, .max_frames = 64}));
  for (int second = 0; second < 3; ++second) play(guarded, 2, 48'000);
  const auto warm = guarded.thermal_state(1);
  CHECK(warm.coil > 0.3);
  REQUIRE(guarded.prepare({.out_channels = 2, .max_frames = 64}));
  CHECK(guarded.thermal_state(1) == warm);
  const JournalEntry coil{0, Kind::CoilHeat, 1, warm.coil}, body{0, Kind::BodyHeat, 1, warm.body};
  CHECK(guarded.state() == std::vector{coil, body});

  // The same entries, posted to a guard that was never warm, make it the same guard.
  Level other{0.6};
  Guarded restored{other, guards};
  REQUIRE(restored.prepare({.out_channels = 2, .max_frames = 64}));
  REQUIRE(restored.post(coil));
  REQUIRE(restored.post(body));
  CHECK(play(restored, 2, 48'000) == play(guarded, 2, 48'000));
  CHECK(restored.thermal_state(1) == guarded.thermal_state(1));
}

TEST_CASE("guarded: on a device what was before is unknown, and the worst is supposed", "[core]") {
  const DriveLimits limits{
      .heat = HeatLimits{.watts_at_full_scale = 10, .watts_for_ever = 5, .coil_time = 100_ms},
      .excursion = ExcursionLimits{.metres = 1e-3, .metres_at_full_scale = 2e-3, .q = 3},
      .dc = {.level = 0.1, .time = 3_s}};
  const std::vector<GuardedChannel> guards = {kAudio, {DriveGuard::Kind::Drive, limits}};
  Level level{0.6}, other{0.6};
  Guarded guarded{level, guards}, restored{other, guards};
  guarded.suppose_worst();
  for (auto* each : {&guarded, &restored}) REQUIRE(each->prepare({.out_channels = 2, .max_frames = 64}));
  CHECK(restored.state().empty());
  const std::vector<JournalEntry> worst = {{0, Kind::CoilHeat, 1, 1.0},
                                           {0, Kind::BodyHeat, 1, 0.5},
                                           {0, Kind::DcTime, 1, 3.0},
                                           {0, Kind::Displacement, 1, 1.0}};
  CHECK(guarded.state() == worst);
  for (const auto& entry : worst) REQUIRE(restored.post(entry));
  CHECK(play(restored, 2, 48'000) == play(guarded, 2, 48'000));

  // When the device returns the warmth is known, the place of the mass is not.
  const auto warm = guarded.thermal_state(1);
  CHECK(warm.coil < 1.0);
  REQUIRE(guarded.prepare({.out_channels = 2, .max_frames = 64}));
  CHECK(guarded.thermal_state(1) == warm);
  CHECK(guarded.state().back() == worst.back());
}

TEST_CASE("guarded: a restart keeps what was muted or disarmed, and forgets what still waited", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive, kDrive, kDrive}};
  REQUIRE(guarded.prepare({.out_channels = 3}));
  REQUIRE(guarded.post({0, Kind::Mute, 0, 1.0}));
  REQUIRE(guarded.post({0, Kind::Arm, 1, 0.0}));
  REQUIRE(guarded.post({100, Kind::Mute, 2, 1.0}));
  play(guarded, 3, 8);
  REQUIRE(guarded.prepare({.out_channels = 3}));
  const auto out = play(guarded, 3, 200);
  CHECK(out[0] == std::vector<double>(200, 0.0));
  CHECK(out[1] == std::vector<double>(200, 0.0));
  CHECK(out[2] == std::vector<double>(200, 1.0));
}

TEST_CASE("guarded: what is ordered between two streams holds from the first frame", "[core]") {
  Level level{0.25};
  Guarded guarded{level, {kDrive, kDrive}};
  REQUIRE(guarded.prepare({.out_channels = 2}));
  play(guarded, 2, 8);
  // No block comes any more: the device is away.
  REQUIRE(guarded.post({JournalEntry::kNow, Kind::Arm, JournalEntry::kAllChannels, 0.0}));
  REQUIRE(guarded.post({JournalEntry::kNow, Kind::Arm, 1, 1.0}));
  REQUIRE(guarded.prepare({.out_channels = 2}));
  const auto back = play(guarded, 2, 8);
  CHECK(back[0] == std::vector<double>(8, 0.0));
  CHECK(back[1] == std::vector<double>(8, 0.25));
  REQUIRE(guarded.post({JournalEntry::kNow, Kind::Mute, JournalEntry::kAllChannels, 1.0}));
  REQUIRE(guarded.prepare({.out_channels = 2}));
  CHECK(play(guarded, 2, 8)[1] == std::vector<double>(8, 0.0));
}

TEST_CASE("guarded: an order for now overtakes those that wait for their frame", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive}};
  REQUIRE(guarded.prepare({.out_channels = 1}));
  REQUIRE(guarded.post({1'000'000, Kind::Arm, 0, 1.0}));
  REQUIRE(guarded.post({JournalEntry::kNow, Kind::Mute, 0, 1.0}));
  CHECK(play(guarded, 1, 8)[0] == std::vector<double>(8, 0.0));
}

TEST_CASE("guarded: recordings may hold silence after noise", "[core]") {
  Level level{1.0};
  Guarded guarded{level, {kDrive}};
  REQUIRE(guarded.prepare({.in_channels = 1, .out_channels = 1, .max_frames = 48'000}));
  const bool trusted = GENERATE(false, true);
  if (trusted) guarded.disable_sensor_watch();
  std::vector<double> in(48'000, 0.0), out(48'000);
  for (std::size_t n = 0; n < 2000; ++n)
    in[n] = static_cast<double>(n * 2654435761u % 1000) * 1e-4;  // noise enough
  const double* from[] = {in.data()};
  double* to[] = {out.data()};
  guarded.process({from, to, 48'000});
  CHECK(out.back() == (trusted ? 1.0 : 0.0));
}

TEST_CASE("guarded: the time that DC has lasted outlives a restart, and is part of the state", "[core]") {
  const std::vector<GuardedChannel> guards = {
      {DriveGuard::Kind::Drive, {.soft_start = Seconds{0}, .dc = {0.2, Seconds{2.0}}}}};
  Level level{0.8};
  Guarded guarded{level, guards};
  const StreamFormat format{.out_channels = 1, .max_frames = 96'000};
  REQUIRE(guarded.prepare(format));
  CHECK(play(guarded, 1, 96'000)[0].back() == 0.8);
  REQUIRE(guarded.prepare(format));
  // The mean, of a time constant of 0.5 s, is above the level from 0.5 s ln(0.8 / 0.6) = 0.144 s on.
  const auto state = guarded.state();
  REQUIRE(state.size() == 1);
  CHECK(state[0].kind == Kind::DcTime);
  CHECK(state[0].value == Approx(2.0 - 0.144).margin(0.003));

  Level other{0.8};
  Guarded restored{other, guards};
  REQUIRE(restored.prepare(format));
  REQUIRE(restored.post(state[0]));
  const auto out = play(guarded, 1, 96'000)[0];
  CHECK(out == play(restored, 1, 96'000)[0]);
  // A drive that begins anew holds 0.8 for two seconds; this one is at level / mean of it by then.
  CHECK(out.back() == Approx(0.8 * 0.2 / (0.8 * (1 - std::exp(-4.0)))).epsilon(1e-3));
}

TEST_CASE("guarded: a sensor that died while the device was away is found after its return", "[core]") {
  Level level{0.5};
  Guarded guarded{level, {kDrive}};
  const StreamFormat format{.in_channels = 1, .out_channels = 1, .max_frames = 4096};
  REQUIRE(guarded.prepare(format));
  std::vector<double> in(4096), out(4096);
  const double* from[] = {in.data()};
  double* to[] = {out.data()};
  for (std::size_t n = 0; n < in.size(); ++n) in[n] = static_cast<double>(n * 2654435761u % 1000) * 1e-4;
  guarded.process({from, to, 4096});
  CHECK(out.back() == 0.5);
  REQUIRE(guarded.prepare(format));
  CHECK(guarded.state() == std::vector<JournalEntry>{{0, Kind::SensorNoise, 0, 1.0}});
  std::fill(in.begin(), in.end(), 0.25);
  guarded.process({from, to, 4096});  // 85 ms
  GuardEvent event;
  REQUIRE(guarded.take_event(event));
  CHECK(event == GuardEvent{1920, GuardEvent::Kind::SensorStuck, 0});
  CHECK(out.back() == 0.0);
}

TEST_CASE("guarded: a feedback path that an edit adds is kept, and part of the state", "[core]") {
  Level level{0.5};
  const GuardedChannel drive{DriveGuard::Kind::Drive, kAtOnce, FeedbackPath{false, false}};
  Guarded guarded{level, {drive, drive}};
  REQUIRE(guarded.prepare({.out_channels = 2}));
  CHECK(guarded.state().empty());
  guarded.add_feedback_paths({{false, false}, {true, false}});
  play(guarded, 2, 8);
  guarded.add_feedback_paths({{false, false}, {false, true}});
  play(guarded, 2, 8);
  const std::vector<JournalEntry> both{{0, Kind::FeedbackPath, 1, 3.0}};
  CHECK(guarded.state() == both);
  REQUIRE(guarded.prepare({.out_channels = 2}));
  CHECK(guarded.state() == both);
}

TEST_CASE("guarded: an edit adds feedback paths to any number of outputs, each journalled once", "[core]") {
  constexpr int kOutputs = 1000;
  Level level{0.5};
  const GuardedChannel drive{DriveGuard::Kind::Drive, kAtOnce, FeedbackPath{false, false}};
  Guarded guarded{level, std::vector(kOutputs, drive)};
  RecordedJournal journal;
  guarded.set_tap(&journal);
  REQUIRE(guarded.prepare({.out_channels = kOutputs}));
  const std::vector paths(kOutputs, FeedbackPath{true, false});
  for (int turn = 0; turn < 2; ++turn) {
    guarded.add_feedback_paths(paths);
    play(guarded, kOutputs, 8);
  }
  CHECK(journal.entries.size() == kOutputs);
  CHECK(guarded.state().size() == kOutputs);
}
