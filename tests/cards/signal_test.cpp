#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <optional>
#include <thread>
#include <utility>

#include "engine/core/not_realtime.h"
#include "tests/cards/ways.h"
#include "tests/support/noise_probe.h"
#include "tests/support/undisturbed.h"
#include "tests/support/wait_until.h"

// RtAudio and PortAudio, over JACK and ALSA, against a real server and a card of known delay: every sample,
// and its frame.

using namespace tactus;
using test::CardOnServer;
using test::every_way;
using test::GuardedProbe;
using test::NoiseProbe;
using test::start_card;
using test::wait_until;
using test::Way;

namespace {

constexpr int kPeriod = 256;

/// Whole runs take time: a short one tells as much.
constexpr int kShort = 4800;

std::unique_ptr<Stream> open(const Way& way, const StreamRequest& request, Guarded& guarded) {
  const auto backend = way.backend();
  auto stream = backend->open(request, guarded);
  if (!stream) throw std::runtime_error{to_string(stream.error())};
  guarded.skip_soft_start();
  return std::move(*stream);
}

/// A run until the probe was full, without lost frames.
struct Run {
  StreamGranted granted;
  std::unique_ptr<GuardedProbe> guarded;
  const NoiseProbe& probe() const { return guarded->probe; }
};

/// Whether an input heard an output all the time, if there are both.
bool heard_all(const NoiseProbe& probe, const StreamRequest& request) {
  bool heard = request.in_channels == 0 || request.out_channels == 0;
  for (int in = 0; in < request.in_channels && !heard; ++in)
    for (int out = 0; out < request.out_channels; ++out) heard = heard || probe.delay(in, out);
  return heard;
}

/// Nothing when frames were lost.
std::optional<Run> run_once(const Way& way, const CardOnServer& rig, const StreamRequest& request,
                            int kept_frames) {
  const auto xruns = rig.card->xruns();
  auto guarded = std::make_unique<GuardedProbe>(request.out_channels, kept_frames);
  const auto& probe = guarded->probe;
  const auto stream = open(way, request, guarded->guarded);
  REQUIRE(stream->start());
  CHECK(stream->state() == StreamState::Running);
  REQUIRE(wait_until([&] { return probe.full(); }, std::chrono::seconds{20}));
  CHECK(stream->stop());
  CHECK(stream->state() == StreamState::Stopped);
  const auto health = stream->health();
  CHECK(health.frames == probe.frames());
  CHECK(health.bad_input == 0);
  CHECK(health.longest_block <= stream->granted().format.max_frames);
  if (health.xruns > 0 || rig.card->xruns() > xruns) return std::nullopt;
  return Run{stream->granted(), std::move(guarded)};
}

/// The ALSA plugin of JACK loses frames on a busy machine without a report. So a run in which nothing came
/// back whole is repeated, twice at most: the last one counts.
Run play(const Way& way, const CardOnServer& rig, const StreamRequest& request, int kept_frames = 48000) {
  int repetitions = way.alsa ? 2 : 0;
  return test::undisturbed("frames were lost", [&] {
    auto run = run_once(way, rig, request, kept_frames);
    if (run && !heard_all(run->probe(), request) && repetitions-- > 0) run.reset();
    return run;
  });
}

std::string refusal(const Way& way, const StreamRequest& request) {
  GuardedProbe probe{request.out_channels};
  const auto stream = way.backend()->open(request, probe.guarded);
  CHECK(probe.probe.prepared == (stream ? 1 : 0));
  return stream ? "" : to_string(stream.error());
}

/// How many frames before the last one that `probe` heard the generator of `noise(0, ...)` played it.
std::int64_t lag(const NoiseProbe& probe, std::int64_t at, std::int64_t longest) {
  // One sample of 22 bits would be found by chance among so many lags.
  const auto is = [&](std::int64_t lag) {
    for (std::int64_t n = at; n < at + 8; ++n)
      if (probe.heard(0)[static_cast<std::size_t>(n)] != NoiseProbe::noise(0, n - lag)) return false;
    return true;
  };
  for (std::int64_t lag = -longest; lag <= longest; ++lag)
    if (is(lag)) return lag;
  throw std::runtime_error{"this is not the noise that was played"};
}

}  // namespace

TEST_CASE("libraries: every sample comes back, the card's delay and two periods later", "[cards]") {
  const auto rig = start_card({.delay_frames = 960});
  for (const auto& way : every_way()) {
    CAPTURE(way.name);
    const auto run = play(way, *rig, rig->request(way, 2, 2));
    const auto& granted = run.granted;
    CHECK(run.probe().delay(0, 0) == 960 + 2 * kPeriod);
    CHECK(run.probe().delay(1, 1) == 960 + 2 * kPeriod);
    CHECK(run.probe().delay(0, 1) == std::nullopt);
    CHECK(granted.format.sample_rate == 48_kHz);
    CHECK(granted.block_frames == (way.name == "portaudio:alsa" ? 0 : kPeriod));
    CHECK(granted.xruns_move_delay == way.alsa);
  }
}

TEST_CASE("libraries: any channels of a card, in any order", "[cards]") {
  const auto rig = start_card({.channels = 6, .delay_frames = 100});
  for (const auto& way : every_way()) {
    CAPTURE(way.name);
    auto request = rig->request(way, 3, 2);
    request.out_map = {1, 4};  // the card's channels 2 and 5
    request.in_map = {4, 1, 0};
    const auto run = play(way, *rig, request, kShort);
    CHECK(run.probe().delay(0, 1) == 100 + 2 * kPeriod);
    CHECK(run.probe().delay(1, 0) == 100 + 2 * kPeriod);
    CHECK(run.probe().heard(2) == std::vector<double>(kShort, 0.0));
  }
}

TEST_CASE("libraries: inputs without outputs, and outputs without inputs", "[cards]") {
  const auto rig = start_card();
  for (const auto& way : every_way()) {
    CAPTURE(way.name);
    CHECK(play(way, *rig, rig->request(way, 0, 2), kShort).granted.input_latency_frames == std::nullopt);
    const auto granted = play(way, *rig, rig->request(way, 2, 0), kShort).granted;
    CHECK(granted.device == rig->request(way, 2, 0).device);
    CHECK(granted.output_latency_frames == std::nullopt);
  }
}

TEST_CASE("libraries: they listen to one device and play to another", "[cards]") {
  const auto rig = start_card({.name = "near", .delay_frames = 10});
  const test::DelayClient far{{.name = "far", .delay_frames = 500}};
  rig->server->connect(rig->card->name() + ":capture_1", far.name() + ":playback_2");
  for (const auto& way : every_way()) {
    if (way.alsa) continue;
    CAPTURE(way.name);
    auto request = rig->request(way, 1, 1);
    request.input_device = way.name + ":" + far.name();
    request.in_map = {1};
    const auto run = play(way, *rig, request, kShort);
    CHECK(run.probe().delay(0, 0) == 10 + 500 + 2 * kPeriod);
    CHECK(run.granted.device == request.device);
    CHECK(run.granted.input_device == request.input_device);
  }
}

TEST_CASE("libraries: a block of any length brings every sample back, or is refused in words",
          "[cards][slow]") {
  const auto rig = start_card();
  for (const auto& way : every_way()) {
    for (const int block : {16, 100, 4096}) {
      CAPTURE(way.name, block);
      auto request = rig->request(way, 1, 1);
      request.block_frames = block;
      const auto error = refusal(way, request);
      CHECK((error.empty() || way.alsa));  // ALSA's JACK plugin takes no shorter block than the server's
      if (error.empty())
        CHECK(play(way, *rig, request, std::max(kShort, 6 * block)).probe().delay(0, 0) >= 960 + kPeriod);
      else
        CHECK(error.size() > 20);
    }
  }
}

TEST_CASE("libraries: they run at the server's rate from 8 kHz to 192 kHz, and at no other",
          "[cards][slow]") {
  const int rate = GENERATE(8000, 192000);
  const auto rig = start_card({.delay_frames = 64}, {.rate = rate});
  for (const auto& way : every_way()) {
    CAPTURE(way.name, rate);
    auto request = rig->request(way, 1, 1);
    const auto run = play(way, *rig, request, kShort);
    CHECK(run.granted.format.sample_rate == Hertz{static_cast<double>(rate)});
    CHECK(run.probe().delay(0, 0) == 64 + 2 * kPeriod);
    for (const double other : {rate + 1.0, 1e6}) {
      request.sample_rate = Hertz{other};
      CHECK(refusal(way, request).find("ate") != std::string::npos);
    }
  }
}

TEST_CASE("libraries: a stream starts and stops a hundred times", "[cards][slow]") {
  for (const auto& way : every_way()) {
    CAPTURE(way.name);
    const auto rig = start_card({}, {.period = way.alsa ? kPeriod : 64});
    GuardedProbe probe{2, 64};
    const auto stream = open(way, rig->request(way, 2, 2), probe.guarded);
    for (int turn = 0; turn < 100; ++turn) {
      CAPTURE(turn);
      const auto before = probe.probe.frames();
      REQUIRE(stream->start());
      REQUIRE(wait_until([&] { return probe.probe.frames() > before; }));
      REQUIRE(stream->stop());
      REQUIRE(stream->state() == StreamState::Stopped);
      REQUIRE(probe.probe.frames() == stream->health().frames);
    }
    CHECK(probe.probe.prepared == 1);
  }
}

TEST_CASE("libraries: a device is opened and closed again and again", "[cards][slow]") {
  const auto rig = start_card();
  for (const auto& way : every_way()) {
    GuardedProbe probe{2, 64};
    for (int turn = 0; turn < 4; ++turn) {
      CAPTURE(way.name, turn);
      const auto stream = open(way, rig->request(way, 2, 2), probe.guarded);
      if (turn % 2 == 0) REQUIRE(stream->start());  // closed while it runs, and before it ever ran
    }
    CHECK(probe.probe.prepared == 4);
  }
}

TEST_CASE("libraries: an xrun of the server is counted once", "[cards]") {
  const auto rig = start_card();
  for (const auto& way : every_way()) {
    if (way.alsa) continue;
    CAPTURE(way.name);
    const auto before = rig->card->xruns();
    GuardedProbe probe{1, 96000};
    const auto stream = open(way, rig->request(way, 1, 1), probe.guarded);
    REQUIRE(stream->start());
    REQUIRE(wait_until([&] { return probe.probe.frames() > 4800; }));
    const auto running = rig->card->xruns();
    for (int late = 0; late < 3; ++late) rig->card->sleep_once(std::chrono::milliseconds{20});
    const auto injected = rig->card->xruns() - running;
    REQUIRE(injected >= 3);
    const auto& counted = [&] { return stream->health().gaps[static_cast<std::size_t>(Gap::Server)]; };
    CHECK(wait_until([&] { return counted() >= injected; }));
    REQUIRE(stream->stop());
    CHECK(counted() <= rig->card->xruns() - before);  // those of a busy machine are counted, too
    CHECK(stream->health().xruns == counted());
  }
}

namespace {

/// Frames that a stream missed while its callback slept for 50 ms: by its clock and by the signal.
struct Missed {
  std::int64_t by_clock = 0;
  std::int64_t by_signal = 0;
};

/// Nothing when there were more gaps than the one that the sleep makes.
std::optional<Missed> miss_frames(const Way& way, const Way& generating_way, const CardOnServer& rig) {
  struct Sleeper final : BlockProcessor {
    Status prepare(const StreamFormat& format) override { return probe.prepare(format); }
    void process(const BlockIo& io) noexcept override {
      probe.process(io);
      if (probe.frames() <= 30000 || std::exchange(slept, true)) return;
      const NotRealtime waits;
      std::this_thread::sleep_for(std::chrono::milliseconds{50});
    }
    NoiseProbe probe{96000};
    bool slept = false;
  };
  GuardedProbe generator{1};
  const auto playing = open(generating_way, rig.request(generating_way, 0, 1), generator.guarded);
  REQUIRE(playing->start());
  Sleeper sleeper;
  Guarded guarded{sleeper, {}};
  guarded.disable_sensor_watch();
  const auto stream = open(way, rig.request(way, 1, 0), guarded);
  REQUIRE(stream->start());
  REQUIRE(wait_until([&] { return sleeper.probe.full(); }, std::chrono::seconds{60}));
  REQUIRE(stream->stop());
  const auto health = stream->health();
  REQUIRE(health.xruns >= 1);
  if (health.xruns > 1 || playing->health().xruns > 0) return std::nullopt;
  return Missed{health.lost_frames, lag(sleeper.probe, 20000, 200000) - lag(sleeper.probe, 90000, 200000)};
}

}  // namespace

TEST_CASE("libraries: frames that the clock finds missing are those that the signal misses", "[cards]") {
  const auto rig = start_card();
  const auto ways = every_way();
  for (const auto& way : ways) {
    if (!way.alsa) continue;
    CAPTURE(way.name);
    const auto missed = test::undisturbed("frames were lost besides those of the test",
                                          [&] { return miss_frames(way, ways.front(), *rig); });
    CHECK(missed.by_signal > 0);
    CHECK(std::abs(missed.by_clock - missed.by_signal) <= kPeriod);  // the clock sees whole blocks
  }
}
