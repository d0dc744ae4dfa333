#include "latency/measurement.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>

#include "engine/core/index.h"
#include "latency/probe/probe_player.h"
#include "tests/latency/simulated_cards.h"
#include "tests/support/allocation_count.h"
#include "tests/support/error_summary.h"
#include "tests/support/fake_backend.h"

using namespace tactus;
using test::Cards;
using test::expect;
using test::loudest;
using test::measured;
using test::named;
using test::on_a_wire;

namespace {

constexpr double kTooLoud = LevelSearch::kTooLoud;

}  // namespace

TEST_CASE("measurement: the delay is right to a thousandth of a frame", "[latency][measurement]") {
  struct Case {
    const char* card;
    double frames;
    int block;
    double rate;
  };
  const auto each = GENERATE(
      Case{"delay=188.25", 188.25, 64, 48e3}, Case{"delay=1000", 1000, 1, 48e3},
      Case{"delay=960.5,gain=-1", 960.5, 512, 48e3}, Case{"delay=300.75,gain=-40dB", 300.75, 128, 48e3},
      Case{"delay=333.1,gain=20dB,noise=-70dB", 333.1, 64, 44.1e3},
      Case{"delay=50,blocks=2,dc=0.05,bits=16", 306, 128, 96e3}, Case{"delay=20000.3", 20000.3, 64, 48e3});
  CAPTURE(each.card);
  auto settings = on_a_wire(2);
  settings.request.block_frames = each.block;
  settings.request.sample_rate = Hertz{each.rate};
  const auto measurement = measured({named(each.card)}, settings);
  CHECK(code(measurement.finding.verdict) == std::string{"ok"});
  CHECK(measurement.delay_frames == Approx(each.frames).epsilon(0).margin(1e-3));
  CHECK(measurement.standard_error_frames < 5e-4);
  CHECK(std::abs(measurement.delay_frames - each.frames) < 6 * measurement.standard_error_frames + 1e-5);
  REQUIRE(measurement.reported_frames);
  CHECK(*measurement.reported_frames == Approx(each.frames));
}

TEST_CASE("measurement: a path of four seconds is waited for", "[latency][measurement]") {
  auto card = named("delay=200000");
  card.gain = GENERATE(1.0, 30.0);  // what was sent on the way, in vain, comes back too loud
  const auto measurement = measured({card});
  CHECK(code(measurement.finding.verdict) == std::string{"ok"});
  CHECK(measurement.delay_frames == Approx(200000.0).epsilon(0).margin(1e-3));
  const auto& recording = measurement.openings.front().recording;
  const auto sweeps = static_cast<std::ptrdiff_t>(recording.played.size()) - 410000;
  CHECK(loudest({recording.captured[0].begin() + sweeps, recording.captured[0].end()}) < kTooLoud);
}

TEST_CASE("measurement: in a howl the output is silent from the frame on in which the input is at its end",
          "[latency][measurement]") {
  auto card = named("delay=100,noise=0");  // so that nothing begins before the first level probe
  card.monitor_gain = 1.5;
  auto settings = on_a_wire(3);
  settings.request.block_frames = GENERATE(16, 64);
  const auto measurement = measured({card}, settings);
  expect(measurement, Verdict::Feedback);
  REQUIRE(measurement.openings.size() == 1);
  const auto& recording = measurement.openings.front().recording;
  const auto& captured = recording.captured[0];
  const auto loud =
      std::find_if(captured.begin(), captured.end(), [](double x) { return std::abs(x) > kTooLoud; });
  REQUIRE(loud != captured.end());
  const auto at = loud - captured.begin();
  REQUIRE(loudest({recording.played.begin() + at - 10, recording.played.begin() + at}) >
          1e-4);  // it was playing
  CHECK(loudest({recording.played.begin() + at, recording.played.end()}) == 0.0);
  CHECK(captured.size() - static_cast<std::size_t>(at) > 14000);  // 0.3 s in which it went on
}

TEST_CASE("measurement: the output fades 500 ms after the stop inputs were handled last",
          "[latency][measurement]") {
  // The loop that handles them is blocked from the beginning: nothing refreshes its dead man's switch.
  const DeadMansSwitch dead_man;
  auto settings = on_a_wire();
  settings.probes = 2;
  const auto free = measured({named("delay=100")}, settings);
  settings.dead_mans_switch = &dead_man;
  LoopBackend in_real_time;
  in_real_time.add("loop:test", named("delay=100"));
  const auto measurement = measure(in_real_time, settings);
  REQUIRE(measurement);
  expect(*measurement, Verdict::LostFrames);
  CHECK(measurement->finding.what.find("stop inputs") != std::string::npos);
  const auto& played = measurement->openings.front().recording.played;
  const auto expired = frames_in(DeadMansWatch::kPatience, 48_kHz);
  const auto faded = expired + frames_in(settings.guard.limits.fade_out, 48_kHz) + 1;
  const auto from = [](const std::vector<double>& samples, double frame) {
    return std::vector<double>(samples.begin() + static_cast<std::ptrdiff_t>(frame), samples.end());
  };
  CHECK(loudest(played) > 0.0);
  CHECK(loudest(from(free.openings.front().recording.played, faded)) > 0.0);
  CHECK(loudest(from(played, faded)) == 0.0);
}

TEST_CASE("measurement: nothing is ever louder than allowed, by the settings or by the guard",
          "[latency][measurement]") {
  auto settings = on_a_wire();
  settings.loudest_dbfs = -20.0;
  const auto quiet = measured({named("no_cable")}, settings);
  CHECK(loudest(quiet.openings.front().recording.played) == Approx(0.1).epsilon(0.01));
  CHECK(loudest(quiet.openings.front().recording.played) <= 0.1);
  settings.guard.limits.ceiling = 0.03;
  CHECK(loudest(measured({named("no_cable")}, settings).openings.front().recording.played) <= 0.03);
}

TEST_CASE("measurement: the level is the softest that stands 30 dB out of the noise",
          "[latency][measurement]") {
  // Noise of -70 dBFS rms asks for -40 dBFS rms, which a sweep has at a peak of -37: -50, -44, -38, -32.
  CHECK(measured({named("noise=-70dB")}).openings.front().level_dbfs == Approx(-32.0).epsilon(0).margin(0.2));
  CHECK(measured({named("noise=-70dB,gain=-10dB")}).openings.front().level_dbfs ==
        Approx(-26.0).epsilon(0).margin(6.0));
  CHECK(measured({named("noise=-110dB")}).openings.front().level_dbfs ==
        Approx(-50.0).epsilon(0).margin(0.01));
}

TEST_CASE("measurement: later openings begin at the level that was found", "[latency][measurement]") {
  const auto measurement = measured({named("noise=-70dB")}, on_a_wire(3));
  REQUIRE(measurement.openings.size() == 3);
  for (const auto& opening : measurement.openings)
    CHECK(opening.level_dbfs == measurement.openings[0].level_dbfs);
  CHECK(measurement.openings[1].recording.played.size() < measurement.openings[0].recording.played.size());
}

TEST_CASE("measurement: five openings last less than 30 s, whatever the delay up to half a second",
          "[latency][measurement]") {
  const auto measurement = measured({named(GENERATE("cable", "480ms,noise=-60dB"))}, on_a_wire(5));
  REQUIRE(measurement.openings.size() == 5);
  double seconds = 0.0;
  for (const auto& opening : measurement.openings)
    seconds += static_cast<double>(opening.recording.played.size()) / 48e3;
  CHECK(seconds < 30.0);
}

TEST_CASE("measurement: neither blocks nor the time that passes change what is played and captured",
          "[latency][measurement]") {
  const auto once = [&](int block) {
    auto settings = on_a_wire();
    settings.request.block_frames = block;
    return measured({named("delay=600.3,noise=-70dB")}, settings);
  };
  const auto first = once(64), again = once(64), longer = once(512), odd = once(17);
  for (const auto* other : {&again, &longer, &odd}) {
    CHECK(other->openings[0].recording.played == first.openings[0].recording.played);
    CHECK(other->openings[0].recording.captured == first.openings[0].recording.captured);
  }
}

TEST_CASE("measurement: a drive is measured within its slew limit", "[latency][measurement]") {
  auto settings = on_a_wire();
  settings.guard = {DriveGuard::Kind::Drive, conservative_limits()};
  const auto measurement = measured({named("20ms,noise=-110dB")}, settings);
  CHECK(code(measurement.finding.verdict) == std::string{"ok"});
  CHECK(measurement.delay_frames == Approx(960.0).epsilon(0).margin(1e-3));
}

TEST_CASE("measurement: settings that make no sense and devices that are not there are errors",
          "[latency][measurement]") {
  Cards backend{{named("20ms")}};
  auto settings = on_a_wire();
  settings.openings = 0;
  CHECK(measure(backend, settings).error().code == Errc::BadArgument);
  settings = on_a_wire();
  settings.softest_dbfs = 0.0;
  CHECK(measure(backend, settings).error().code == Errc::OutOfRange);
  settings = on_a_wire();
  settings.request.device = "loop:nothing";
  CHECK(measure(backend, settings).error().code == Errc::UnknownName);
  settings = on_a_wire();
  settings.input = 2;
  CHECK(measure(backend, settings).error().code == Errc::OutOfRange);
}

TEST_CASE("measurement: nothing is played to a drive where other writers are there or cannot be seen",
          "[latency][measurement]") {
  test::FakeWorld world;
  world.starts = false;  // so that what would have been played is an error of its own
  struct OneDevice final : test::FakeBackend {
    using FakeBackend::FakeBackend;
    Result<std::vector<Device>> devices() override {
      Device one;
      one.id = one.name = "fake:one";
      one.in_channels = one.out_channels = 1;
      one.default_rate = 48_kHz;
      return std::vector{one};
    }
  };
  OneDevice backend{world};
  const auto said = [&](DriveGuard::Kind kind, bool shared) {
    MeasureSettings settings;
    settings.guard.kind = kind;
    settings.shared_port = shared;
    settings.request.device = "fake:one";
    const auto result = measure(backend, settings);
    REQUIRE_FALSE(result);
    return result.error().what;
  };
  const std::string started = "it does not start";
  CHECK(said(DriveGuard::Kind::Drive, false) == started);
  world.writers_unknown = true;
  CHECK(said(DriveGuard::Kind::Drive, false) == "this library does not show who else writes to the output");
  CHECK(said(DriveGuard::Kind::Drive, true) == started);
  CHECK(said(DriveGuard::Kind::Audio, false) == started);  // nothing but a cable
  world.writers_unknown = false;
  world.writers = {{0, "player:out_1", "card:playback_1"}};
  for (const auto kind : {DriveGuard::Kind::Drive, DriveGuard::Kind::Audio}) {
    CHECK(said(kind, false) == "'player:out_1' also writes to 'card:playback_1'");
    CHECK(said(kind, true) == started);
  }
}

namespace {

/// A simulated card whose openings are granted what a test says, in turn; the last one from then on.
class ChangingCard final : public Backend {
 public:
  explicit ChangingCard(std::vector<StreamGranted> granted) : granted_(std::move(granted)) {}
  std::string name() const override { return loop_.name(); }
  Result<std::vector<Device>> devices() override { return loop_.devices(); }
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, GuardedBlocks& processor) override {
    auto stream = loop_.open(request, processor);
    if (!stream) return tl::unexpected(stream.error());
    const auto at = std::min(opened++, std::ssize(granted_) - 1);
    return std::make_unique<Renamed>(std::move(*stream), granted_[index(at)], started);
  }

  std::ptrdiff_t opened = 0;
  int started = 0;

 private:
  class Renamed final : public Stream {
   public:
    Renamed(std::unique_ptr<Stream> stream, const StreamGranted& identity, int& started)
        : stream_(std::move(stream)), granted_(stream_->granted()), started_(started) {
      granted_.input = identity.input;
      granted_.output = identity.output;
      granted_.connection = identity.connection;
      if (identity.block_frames > 0) granted_.block_frames = identity.block_frames;
      if (identity.periods > 0) granted_.periods = identity.periods;
    }
    const StreamGranted& granted() const override { return granted_; }
    Status start(const std::function<void()>& ready) override { return ++started_, stream_->start(ready); }
    Status stop() override { return stream_->stop(); }
    StreamState state() const override { return stream_->state(); }
    Health health() const override { return stream_->health(); }

   private:
    std::unique_ptr<Stream> stream_;
    StreamGranted granted_;
    int& started_;
  };

  std::vector<StreamGranted> granted_;
  LoopBackend loop_{LoopBackend::Pace::AsFastAsPossible};
};

MeasureSettings two_openings() {
  auto settings = on_a_wire(2);
  settings.request.device = "loop:cable";
  settings.probes = 2;
  return settings;
}

/// Of a card that is known by its ports, and by the server that it is connected to.
StreamGranted granted_ports() {
  StreamGranted granted;
  granted.input = {"", 2, {"card:capture_1", "card:capture_2"}, false};
  granted.output = {"", 2, {"card:playback_1"}, false};
  granted.connection = "7";
  return granted;
}

}  // namespace

TEST_CASE("measurement: nothing is played to another device that has the name by the second opening",
          "[latency][measurement]") {
  const auto first = granted_ports();
  auto second = first;
  std::string names;
  SECTION("it has other outputs") {
    second.output.channels = 4;
    names = "4 2";
  }
  SECTION("its outputs are in another order") {
    second.output.ports = {"card:playback_4"};
    names = "1 'card:playback_4' 'card:playback_1'";
  }
  SECTION("its inputs are in another order") {
    std::swap(second.input.ports[0], second.input.ports[1]);
    names = "1 'card:capture_2' 'card:capture_1' 2 'card:capture_1' 'card:capture_2'";
  }
  SECTION("it is other hardware") {
    second.output.hardware = "1-3:1.0";
    names = "'1-3:1.0' ''";
  }
  SECTION("it left the server and came back") { second.connection = "9"; }
  SECTION("it has another block") {
    second.block_frames = 128;
    names = "128 64";
  }
  SECTION("it has another number of periods") {
    second.periods = 7;
    names = "7 ";
  }
  ChangingCard card{{first, second}};
  const auto measurement = measure(card, two_openings());
  REQUIRE_FALSE(measurement);
  CHECK(measurement.error().code == Errc::Device);
  CHECK(measurement.error().where == "loop:cable");
  CHECK(test::names_in(measurement.error().what).starts_with(names));
  CHECK(measurement.error().what.size() > 80);  // and says in what it differs
  CHECK(card.opened == 2);
  CHECK(card.started == 1);
}

TEST_CASE("measurement: a device of unknown hardware that stays is measured at each opening",
          "[latency][measurement]") {
  auto granted = granted_ports();
  granted.output.ambiguous = GENERATE(false, true);
  ChangingCard card{{granted}};
  const auto measurement = measure(card, two_openings());
  REQUIRE(measurement);
  CHECK(measurement->openings.size() == 2);
  CHECK(card.started == 2);
}

TEST_CASE("measurement: after an earlier one it is of the same device, whatever its settings",
          "[latency][measurement]") {
  auto settings = two_openings();
  settings.previous = granted_ports();
  settings.previous->device = settings.request.device;
  settings.previous->block_frames = 256;
  settings.previous->periods = 3;
  settings.previous->format.sample_rate = 96_kHz;
  ChangingCard same{{granted_ports()}};
  CHECK(measure(same, settings));
  CHECK(same.started == 2);
  auto other = granted_ports();
  other.connection = "9";
  ChangingCard replaced{{other}};
  const auto refused = measure(replaced, settings);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == Errc::Device);
  CHECK(replaced.started == 0);
}

TEST_CASE("measurement: no opening begins by itself after the stop inputs were not handled for 5 s",
          "[latency][measurement]") {
  static std::chrono::nanoseconds now;
  DeadMansSwitch dead_man{[] { return now; }};
  auto settings = two_openings();
  settings.dead_mans_switch = &dead_man;
  ChangingCard card{{granted_ports()}};
  bool stopped = false;
  const auto measurement = measure(card, settings, [&](double, const std::string&) {
    // As when the program is stopped in the first opening and goes on.
    if (!std::exchange(stopped, true)) now += std::chrono::milliseconds{5100};
    dead_man.refresh();
  });
  REQUIRE(stopped);
  REQUIRE_FALSE(measurement);
  CHECK(measurement.error().code == Errc::Device);
  CHECK(measurement.error().what.find("stop inputs") != std::string::npos);
  CHECK(card.started == 1);
}

TEST_CASE("measurement: progress only grows", "[latency][measurement]") {
  Cards backend{{named("20ms")}};
  double before = 0.0;
  bool grows = true;
  std::string said;
  REQUIRE(measure(backend, on_a_wire(2), [&](double share, const std::string& what) {
    grows = grows && share >= before && share <= 1.0;
    before = share;
    said = what;
  }));
  CHECK(grows);
  CHECK(before > 0.5);
  CHECK(said == "opening 2 of 2");
}

TEST_CASE("probe_player: nothing is allocated while it plays", "[latency][measurement]") {
  ProbePlayer player;
  ProbePlayer::Script script;
  script.level.softest = 0.003;
  script.level.loudest = 0.5;
  player.set_script(script);
  Guarded guarded{player, {{DriveGuard::Kind::Audio, {}}}};
  guarded.set_tap(&player);
  constexpr int kBlock = 48;
  REQUIRE(guarded.prepare({48_kHz, 1, 1, kBlock}));
  std::vector<double> in(kBlock), out(kBlock);
  const double* ins[] = {in.data()};
  double* outs[] = {out.data()};
  const auto before = test::allocation_count();
  int blocks = 0;
  for (; !player.done() && blocks < 20000; ++blocks) {
    guarded.process({ins, outs, kBlock});
    in = out;  // a delay of one block
  }
  CHECK(test::allocation_count() == before);
  CHECK(player.done());
  CHECK(player.outcome() == ProbePlayer::Outcome::Played);
  CHECK(blocks > 5000);
  CHECK(player.take_recording().captured[0].size() > 240000);
}
