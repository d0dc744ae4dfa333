#include "engine/guard/feedback_detector.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "engine/guard/guarded.h"
#include "tests/engine/guard/random_loops.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr Hertz kRate = kLoopRate;
constexpr FeedbackPath kNone{false, false}, kThroughInput{true, false}, kInternal{false, true};

/// Plays what `source` wants through a guard, frame by frame, and returns the time at which it was faded.
template <class Source>
std::optional<double> faded_at(Source& source, const DriveLimits& limits, const FeedbackPath& path,
                               double seconds, double* first_limited_s = nullptr) {
  DriveGuard guard{DriveGuard::Kind::Drive, limits, kRate, path};
  guard.set_open(true, 0);
  bool limited = false;
  for (int n = 0; n < seconds * kRate.value; ++n) {
    const double wanted = source.next();
    double y = wanted;
    guard.process(&y, 1, n);
    source.took(wanted, y);
    if (!limited && first_limited_s != nullptr && guard.counts() != GuardCounts{}) {
      limited = true;
      *first_limited_s = n / kRate.value;
    }
    if (const auto frame = guard.take_feedback()) return static_cast<double>(*frame) / kRate.value;
  }
  return std::nullopt;
}

/// A signal that depends on time alone.
template <class Signal>
struct Outside {
  Signal signal;
  int frame = 0;
  double next() { return signal(frame++); }
  void took(double, double) {}
};
template <class Signal>
Outside(Signal) -> Outside<Signal>;

template <class Signal>
bool fades(const DriveLimits& limits, double seconds, Signal signal) {
  Outside source{signal};
  return faded_at(source, limits, {}, seconds).has_value();
}

struct Silence {
  double from_s, to_s;
};

/// When the output of a guard was silent for 10 ms and more, while the loop or signal wanted to be loud.
template <class Source>
std::vector<Silence> silences(Source& source, double seconds) {
  DriveGuard guard{DriveGuard::Kind::Drive, {}, kRate, kThroughInput};
  guard.set_open(true, 0);
  guard.skip_soft_start();
  std::vector<Silence> found;
  double loud_s = 0.0, now_s = 0.0;
  const auto end = [&] {
    if (now_s - loud_s > 0.01) found.push_back({loud_s, now_s});
  };
  for (int n = 0; n < seconds * kRate.value; ++n) {
    const double wanted = source.next();
    double y = wanted;
    guard.process(&y, 1, n);
    source.took(wanted, y);
    now_s = n / kRate.value;
    if (y == 0.0) continue;
    end();
    loud_s = now_s;
  }
  end();
  return found;
}

struct Caught {
  int loops = 0, caught = 0;
  double slowest_s = 0.0;
};

/// Random unstable loops, each for 100 s at most.
Caught catch_loops(unsigned seed, int loops, const LoopDelays& delays = {}) {
  std::mt19937 random{seed};
  Caught result{loops};
  for (int turn = 0; turn < loops; ++turn) {
    const auto shape = LoopShape::random_unstable(random, delays);
    const auto limits = random_limits(random);
    Loop loop{shape, static_cast<unsigned>(turn)};
    double limited_s = 0.0;
    const auto at = faded_at(loop, limits, shape.internal ? kInternal : kThroughInput, 100.0, &limited_s);
    result.caught += at ? 1 : 0;
    if (at) result.slowest_s = std::max(result.slowest_s, *at - limited_s);
    if (at) continue;
    std::printf("missed: gain %g, delay %d frames, %zu modes, %s, limited at %g s\n", shape.gain, shape.delay,
                shape.modes.size(), shape.internal ? "inside the graph" : "through an input", limited_s);
  }
  return result;
}

bool is_false_fade(unsigned seed, int turn, double seconds) {
  std::mt19937 random{seed * 7919 + static_cast<unsigned>(turn)};
  const auto limits = random_limits(random);
  LoudInstrument instrument{static_cast<unsigned>(random())};
  const auto at = faded_at(instrument, limits, {}, seconds);
  if (at) std::printf("false: turn %d, kind %d, at %g s\n", turn, instrument.kind(), *at);
  return at.has_value();
}

int count_false_fades(unsigned seed, int instruments, double seconds) {
  int fades = 0;
  for (int turn = 0; turn < instruments; ++turn) fades += is_false_fade(seed, turn, seconds) ? 1 : 0;
  return fades;
}

/// Both outputs double every millisecond from frame 0 on, and start again before they overflow.
class Diverging final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat&) override { return {}; }
  void process(const BlockIo& io) noexcept override {
    for (int n = 0; n < io.frames; ++n, ++frame_)
      io.out[0][n] = io.out[1][n] =
          (frame_ % 2 == 0 ? 1e-3 : -1e-3) * std::exp2(static_cast<double>(frame_ % 40'000) / 48.0);
  }

 private:
  int frame_ = 0;
};

}  // namespace

TEST_CASE("feedback: random unstable loops are faded", "[core]") {
  const auto result = catch_loops(1, 60);
  CHECK(result.caught == result.loops);
}

TEST_CASE("feedback: 1,000 random unstable loops", "[.soak]") {
  const auto result = catch_loops(11, 1000);
  std::printf("%d of %d caught, the slowest %.2f s after its first limited frame\n", result.caught,
              result.loops, result.slowest_s);
  CHECK(result.caught == result.loops);
}

TEST_CASE("feedback: random unstable loops with delays of 40 to 80 ms are faded", "[core]") {
  const auto result = catch_loops(1, 20, {1920, 3840});
  CHECK(result.caught == result.loops);
}

TEST_CASE("feedback: random unstable loops with longer delays", "[.soak]") {
  for (const LoopDelays delays : {LoopDelays{1920, 3840}, LoopDelays{3840, 7680}, LoopDelays{7680, 19'200}}) {
    const auto result = catch_loops(12, 300, delays);
    std::printf("delays of %g to %g ms: %d of %d caught, the slowest after %.2f s\n", delays.least / 48.0,
                delays.most / 48.0, result.caught, result.loops, result.slowest_s);
  }
}

TEST_CASE("feedback: a resonance that has not grown to its end is no outside signal in a trial", "[core]") {
  // It rings on by more than it was when it was silenced; such loops stayed at the limit before.
  Loop loop{{.gain = 39.0, .delay = 665, .modes = {Mode::of(24.6, 30)}, .noise = 0.02}, 1};
  double limited_s = 0.0;
  const auto at = faded_at(loop, {.ceiling = 0.59}, kThroughInput, 30.0, &limited_s);
  REQUIRE(at);
  CHECK(*at - limited_s < 20.0);
}

TEST_CASE("feedback: a loop with a delay of 100 to 160 ms is faded within 20 s of its first limited frame",
          "[core]") {
  const double gain = GENERATE(1.2, 4.0);
  const int delay = GENERATE(4800, 7680);
  const std::vector<Mode> modes = GENERATE(std::vector<Mode>{}, std::vector{Mode::of(60, 2)});
  CAPTURE(gain, delay, modes.size());
  Loop loop{{.gain = gain, .delay = delay, .modes = modes, .noise = 1e-5}, 1};
  double limited_s = 0.0;
  const auto at = faded_at(loop, {}, kThroughInput, 60.0, &limited_s);
  REQUIRE(at);
  CHECK(*at - limited_s < 20.0);
}

TEST_CASE("feedback: loud stable instruments are limited and not faded", "[core]") {
  CHECK(count_false_fades(1, 60, 5.0) == 0);
}

TEST_CASE("feedback: a crescendo that begins again and again is no feedback", "[core]") {
  // Two that fall during every silence, in times that are nearly equal.
  for (const int turn : {3, 58}) CHECK_FALSE(is_false_fade(11, turn, 20.0));
}

TEST_CASE("feedback: bursts that end just before each silence are no feedback", "[core]") {
  for (const double period : {0.73, 0.75, 0.77}) {
    CAPTURE(period);
    std::mt19937 random{1};
    CHECK_FALSE(fades({.ceiling = 0.5}, 20.0, [&](int n) {
      const double noise = std::uniform_real_distribution<double>{-1, 1}(random);
      return std::fmod(n / kRate.value, period) < 0.15 ? 5 * noise : 0.0;
    }));
  }
}

TEST_CASE("feedback: a tone that is not limited itself does not hide a loop", "[core]") {
  const double gain = GENERATE(1.5, 2.0);
  struct Mixed {
    Loop loop;
    int frame = 0;
    double tone() const { return 0.4 * std::sin(2 * kPi * 311.0 * frame / kRate.value); }
    double next() { return loop.next() + tone(); }
    void took(double wanted, double out) { loop.took(wanted - tone(), out), ++frame; }
  };
  Mixed mixed{Loop{{.gain = gain, .delay = 1000, .noise = 1e-3}, 1}};
  CHECK(faded_at(mixed, {.ceiling = 0.5}, kThroughInput, 20.0));
}

TEST_CASE("feedback: only a loop of the graph is found by its growth", "[core]") {
  // By 40 dB beyond the ceiling within a second, in a straight line.
  const auto crescendo = [] {
    return Outside{[](int n) { return std::exp2(n / 7200.0) * std::sin(2 * kPi * 200.0 * n / kRate.value); }};
  };
  auto inside = crescendo(), outside = crescendo();
  CHECK(faded_at(inside, {}, kInternal, 1.1));
  CHECK_FALSE(faded_at(outside, {}, kThroughInput, 1.1));
}

TEST_CASE("feedback: 1,000 loud stable instruments", "[.soak]") {
  const int fades = count_false_fades(11, 1000, 20.0);
  std::printf("%d false fades\n", fades);
  CHECK(fades <= 2);
}

TEST_CASE("feedback: a loop through an input is faded within 0.12 s of its first limited frame", "[core]") {
  const double gain = GENERATE(1.2, 4.0, 30.0);
  const int delay = GENERATE(48, 480);
  CAPTURE(gain, delay);
  Loop loop{{.gain = gain, .delay = delay, .noise = 1e-3}, 1};
  double limited_s = 0.0;
  const auto at = faded_at(loop, {}, kThroughInput, 30.0, &limited_s);
  REQUIRE(at);
  CHECK(*at - limited_s < 0.12);
}

TEST_CASE(
    "feedback: a loop that rings for longer than the pattern is silent as soon as it was limited for 0.1 s",
    "[core]") {
  const LoopShape shape{.gain = 28, .delay = 1670, .modes = {Mode::of(25, 18.6)}, .noise = 0.02};
  Loop loop{shape, 1};
  double limited_s = 0.0;
  const auto at = faded_at(loop, {}, kThroughInput, 20.0, &limited_s);
  REQUIRE(at);
  Loop again{shape, 1};
  const auto silent = silences(again, *at);
  REQUIRE_FALSE(silent.empty());
  CHECK(silent.front().from_s - limited_s < 0.12);
}

TEST_CASE("feedback: a steady signal beyond the limit is silenced for 0.2 s in ten seconds", "[core]") {
  Outside tone{[](int n) { return 3.0 * std::sin(2 * kPi * 400.0 * (n + 0.5) / kRate.value); }};
  const auto silent = silences(tone, 10.0);
  REQUIRE(silent.size() == 1);
  // Limited in more than half of 200 ms, silent after 5 ms and let through after 20 steps of 10.7 ms.
  CHECK(silent[0].from_s == Approx(0.106).margin(0.003));
  CHECK(silent[0].to_s - silent[0].from_s == Approx(0.208).margin(0.012));
}

TEST_CASE("feedback: without a path a drive is limited exactly, whatever is wanted of it", "[core]") {
  std::mt19937 random{5};
  std::uniform_real_distribution<double> noise{-10, 10};
  DriveGuard guard{DriveGuard::Kind::Drive, {.ceiling = 0.5}, kRate, kNone};
  guard.set_open(true, 0);
  bool exact = true;
  for (int n = 0; n < 96'000; ++n) {
    const double wanted = n < 48'000 ? noise(random) : 1e-3 * std::exp2((n - 48'000) / 48.0);
    double y = wanted;
    guard.process(&y, 1, n);
    exact = exact && y == std::clamp(wanted, -0.5, 0.5);
  }
  CHECK(exact);
  CHECK_FALSE(guard.take_feedback());
}

TEST_CASE("feedback: where limiting counts, more than half of 200 ms of it is enough", "[core]") {
  Outside tone{[](int n) { return 0.9 * std::sin(2 * kPi * 400.0 * n / kRate.value); }};
  const auto at = faded_at(tone, {.slew_per_second = 1000.0}, {false, false, true}, 1.0);
  REQUIRE(at);
  CHECK(*at == Approx(0.1).margin(0.005));
}

TEST_CASE("feedback: a path that is added later counts from then on", "[core]") {
  DriveGuard guard{DriveGuard::Kind::Drive, {}, kRate, kNone};
  guard.set_open(true, 0);
  Diverging diverging;
  std::vector<double> drive(48'000), other(48'000);
  double* out[] = {drive.data(), other.data()};
  diverging.process({nullptr, out, 48'000});
  guard.process(drive.data(), 48'000, 0);
  CHECK_FALSE(guard.take_feedback());
  guard.add_feedback_path(kInternal);
  diverging.process({nullptr, out, 48'000});
  guard.process(drive.data(), 48'000, 48'000);
  CHECK(guard.take_feedback());
}

TEST_CASE("feedback: tones, square waves and strokes beyond the limits are no feedback", "[core]") {
  const auto tone = [](double hz, double size) {
    return [=](int n) { return size * std::sin(2 * kPi * hz * (n + 0.5) / kRate.value); };
  };
  for (const double hz : {50.0, 400.0, 3000.0}) {
    CAPTURE(hz);
    CHECK_FALSE(fades({}, 4.0, tone(hz, 3.0)));
    CHECK_FALSE(fades({.slew_per_second = 300.0}, 4.0, tone(hz, 1.0)));
    CHECK_FALSE(fades({}, 4.0, [&](int n) { return tone(hz, 1.0)(n) > 0 ? 1.5 : -1.5; }));
  }
  // 30 strokes a second is the fastest controlled roll.
  for (const double rate : {4.0, 16.0, 30.0}) {
    CAPTURE(rate);
    CHECK_FALSE(
        fades({}, 4.0, [=](int n) { return 1.6 * std::exp(-std::fmod(n / kRate.value, 1 / rate) / 0.006); }));
  }
}

TEST_CASE("feedback: an output that faded stays silent until it is armed again, and then starts softly",
          "[core]") {
  Diverging diverging;
  const DriveLimits limits{.soft_start = 10_ms};
  Guarded guarded{
      diverging,
      {{DriveGuard::Kind::Drive, limits, kInternal}, {DriveGuard::Kind::Audio, limits, kInternal}}};
  REQUIRE(guarded.prepare({.sample_rate = kRate, .out_channels = 2}));
  std::vector<double> drive(4096), audio(4096);
  double* out[] = {drive.data(), audio.data()};
  const auto play = [&](int blocks) {
    for (int n = 0; n < blocks; ++n) guarded.process({nullptr, out, 4096});
  };
  play(5);  // 0.43 s
  GuardEvent event;
  for (const int channel : {0, 1}) {
    REQUIRE(guarded.take_event(event));
    CHECK(event.kind == GuardEvent::Kind::Feedback);
    CHECK(event.channel == channel);
    // It reaches full scale after 10 ms, and has then to be limited for 100 ms.
    CHECK(static_cast<double>(event.frame) / kRate.value == Approx(0.11).margin(0.003));
  }
  CHECK_FALSE(guarded.take_event(event));
  play(20);
  CHECK(drive == std::vector<double>(4096, 0.0));
  CHECK(audio == std::vector<double>(4096, 0.0));
  REQUIRE(guarded.post({JournalEntry::kNow, JournalEntry::Kind::Arm, JournalEntry::kAllChannels, 1.0}));
  play(1);
  CHECK(std::abs(audio[48]) <= 48.0 / 480);
}
