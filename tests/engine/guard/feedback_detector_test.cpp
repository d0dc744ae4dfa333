#include "engine/guard/feedback_detector.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <random>
#include <vector>

#include "engine/core/units.h"
#include "engine/guard/guarded.h"

using namespace tactus;

namespace {

constexpr Hertz kRate = 48_kHz;

double logarithmic(std::mt19937& random, double low, double high) {
  return low * std::pow(high / low, std::uniform_real_distribution<double>{0, 1}(random));
}

/// What a loop does to what went out: gain * resonance, behind a delay. The resonance is a band pass with 0
/// dB at its centre (R. Bristow-Johnson, "Audio EQ cookbook"); without one, nothing but the gain.
struct LoopShape {
  double gain;
  int delay;
  bool resonant;
  double b = 0, a1 = 0, a2 = 0;

  static LoopShape random(std::mt19937& random) {
    LoopShape shape{(random() % 2 == 0 ? 1 : -1) * logarithmic(random, 1.05, 30),
                    static_cast<int>(logarithmic(random, 1, 1920)), random() % 3 != 0};
    const double w = 2 * kPi * logarithmic(random, 20, 2000) / kRate.value;
    const double alpha = std::sin(w) / (2 * logarithmic(random, 0.7, 30));
    shape.b = alpha / (1 + alpha);
    shape.a1 = -2 * std::cos(w) / (1 + alpha);
    shape.a2 = (1 - alpha) / (1 + alpha);
    return shape;
  }
  std::complex<double> open_loop(double hz) const {
    const auto z = std::polar(1.0, -2 * kPi * hz / kRate.value);
    const auto resonance = resonant ? b * (1.0 - z * z) / (1.0 + a1 * z + a2 * z * z) : 1.0;
    return gain * resonance * std::pow(z, delay);
  }
  /// Nyquist: the phase of the open loop only ever falls, so each time that it passes a whole turn with a
  /// magnitude above 1 is a mode that grows. Looked for up to 5 kHz, and above 1.05: to be certain.
  bool unstable() const {
    if (!resonant) return true;
    auto before = open_loop(5.0);
    for (double hz = 5.5; hz < 5000; hz += 0.5) {
      const auto here = open_loop(hz);
      if (before.imag() >= 0 && here.imag() < 0 && std::min(before.real(), here.real()) > 1.05) return true;
      before = here;
    }
    return false;
  }
};

/// Such a loop through the guard, set off by a little noise.
class Loop final : public BlockProcessor {
 public:
  Loop(const LoopShape& shape, unsigned seed)
      : shape_(shape), past_(static_cast<std::size_t>(shape.delay), 0.0), random_(seed) {}
  Status prepare(const StreamFormat&) override { return {}; }
  void process(const BlockIo& io) noexcept override {
    for (int n = 0; n < io.frames; ++n) {
      const double x = past_[at_];
      double y = x;
      if (shape_.resonant) {
        y = shape_.b * (x - x2_) - shape_.a1 * y1_ - shape_.a2 * y2_;
        x2_ = x1_, x1_ = x, y2_ = y1_, y1_ = y;
      }
      io.out[0][n] = shape_.gain * y + 0.02 * (std::uniform_real_distribution<double>{-1, 1}(random_));
    }
  }
  /// What the guard let out of the last block, of one frame.
  void observe(double y) {
    past_[at_] = y;
    at_ = (at_ + 1) % past_.size();
  }

 private:
  LoopShape shape_;
  double x1_ = 0, x2_ = 0, y1_ = 0, y2_ = 0;
  std::vector<double> past_;
  std::size_t at_ = 0;
  std::mt19937 random_;
};

DriveLimits some_limits(std::mt19937& random) {
  DriveLimits limits{.ceiling = logarithmic(random, 0.2, 1.0)};
  if (random() % 2 == 0) limits.slew_per_second = logarithmic(random, 300, 50'000);
  if (random() % 2 == 0)
    limits.excursion = ExcursionLimits{.metres = 1.0,
                                       .metres_at_full_scale = logarithmic(random, 0.3, 3),
                                       .resonance = Hertz{logarithmic(random, 20, 200)},
                                       .q = logarithmic(random, 0.3, 15)};
  if (random() % 4 == 0) limits = conservative_limits();
  return limits;
}

/// Plays a drive that wants signal(frame) for `frames` frames; true if it was faded.
template <class Signal>
bool fades(const DriveLimits& limits, int frames, Signal signal) {
  DriveGuard guard{DriveGuard::Kind::Drive, limits, kRate};
  guard.set_open(true, 0);
  for (int n = 0; n < frames; ++n) {
    double y = signal(n);
    guard.process(&y, 1, n);
    if (guard.take_feedback()) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("howl: every one of 1,000 random unstable loops is faded", "[core]") {
  std::mt19937 random{2024};
  int caught = 0;
  double slowest_s = 0.0;
  for (int turn = 0; turn < 1000; ++turn) {
    auto shape = LoopShape::random(random);
    while (!shape.unstable()) shape = LoopShape::random(random);
    Loop loop{shape, static_cast<unsigned>(turn)};
    Guarded guarded{loop, {{DriveGuard::Kind::Drive, some_limits(random)}}};
    REQUIRE(guarded.prepare({.sample_rate = kRate, .out_channels = 1, .max_frames = 1}));
    double y = 0.0;
    double* out = &y;
    GuardEvent event;
    bool detected = false;
    for (int n = 0; n < 48'000 * 30 && !detected; ++n) {
      guarded.process({nullptr, &out, 1});
      loop.observe(y);
      detected = guarded.take_event(event);
      if (detected) slowest_s = std::max(slowest_s, n / kRate.value);
    }
    caught += detected ? 1 : 0;
    if (!detected) UNSCOPED_INFO("missed: gain " << shape.gain << ", delay " << shape.delay << " frames");
  }
  INFO("slowest " << slowest_s << " s");
  CHECK(caught == 1000);
}

TEST_CASE("howl: a full-scale square wave at the ceiling is no howl, at any pitch", "[core]") {
  const auto square = [](double hz, double size) {
    return [=](int n) { return std::sin(2 * kPi * hz * (n + 0.5) / kRate.value) > 0 ? size : -size; };
  };
  for (const double hz : {0.5, 5.0, 50.0, 500.0, 5000.0}) CHECK_FALSE(fades({}, 96'000, square(hz, 1.0)));
  // Its edges through a slew limit that needs 2 ms for them, up to where they fill a third of the time.
  for (const double hz : {0.5, 5.0, 20.0}) {
    CAPTURE(hz);
    CHECK_FALSE(fades({.slew_per_second = 1000.0}, 96'000, square(hz, 1.0)));
  }
  CHECK(fades({}, 96'000, square(50.0, 1.01)));
}

TEST_CASE("howl: strokes whose tops are cut off are no howl, at any speed that a drummer reaches", "[core]") {
  // 30 strokes a second is the fastest controlled roll.
  const double rate = GENERATE(4.0, 16.0, 25.0);
  const auto strokes = [=](int n) { return 1.6 * std::exp(-std::fmod(n / kRate.value, 1 / rate) / 0.006); };
  CHECK_FALSE(fades({}, 96'000, strokes));
}

TEST_CASE("howl: a drive that faded stays silent until it is armed again, and then starts softly", "[core]") {
  class Siren final : public BlockProcessor {
   public:
    Status prepare(const StreamFormat&) override { return {}; }
    void process(const BlockIo& io) noexcept override {
      for (int n = 0; n < io.frames; ++n) io.out[0][n] = io.out[1][n] = n % 2 == 0 ? 2.0 : -2.0;
    }
  } siren;
  const DriveLimits limits{.soft_start = 10_ms};
  Guarded guarded{siren, {{DriveGuard::Kind::Drive, limits}, {DriveGuard::Kind::Audio, limits}}};
  REQUIRE(guarded.prepare({.sample_rate = kRate, .out_channels = 2}));
  std::vector<double> drive(4096), audio(4096);
  double* out[] = {drive.data(), audio.data()};
  const auto play = [&](int blocks) {
    for (int n = 0; n < blocks; ++n) guarded.process({nullptr, out, 4096});
  };
  play(5);  // 0.43 s
  GuardEvent event;
  REQUIRE(guarded.take_event(event));
  CHECK(event.kind == GuardEvent::Kind::Feedback);
  CHECK(event.channel == 0);
  CHECK(static_cast<double>(event.frame) / kRate.value ==
        Approx(0.11).margin(0.01));  // 5 ms of soft start, 101 ms of howl
  CHECK_FALSE(guarded.take_event(event));
  play(20);
  CHECK(*std::max_element(drive.begin(), drive.end()) == 0.0);
  CHECK(*std::max_element(audio.begin(), audio.end()) == 1.0);  // audio outputs go on
  REQUIRE(guarded.post({JournalEntry::kNow, JournalEntry::Kind::Arm, 0, 1.0}));
  play(1);
  CHECK(drive[48] == Approx(48.0 / 480));  // of the ceiling, although 2 comes in
  CHECK(drive[4094] == 1.0);
}
