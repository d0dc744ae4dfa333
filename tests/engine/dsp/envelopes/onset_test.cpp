#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "engine/dsp/envelopes/onset_kernel.h"

namespace tactus {
namespace {

constexpr double kRate = 48000;
using Samples = std::vector<double>;

int frames(double seconds) { return static_cast<int>(std::lround(seconds * kRate)); }
double ratio(double db) { return std::pow(10.0, db / 20); }

/// Adds a cos(2 pi f t) e^(-t / tau), starting at `start_s` with its highest frame.
void strike(Samples& to, double start_s, double a, double f, double tau) {
  for (std::size_t n = static_cast<std::size_t>(frames(start_s)); n < to.size(); ++n) {
    const double t = static_cast<double>(n) / kRate - start_s;
    to[n] += a * std::cos(2 * std::numbers::pi * f * t) * std::exp(-t / tau);
  }
}

Samples silence(double seconds) { return Samples(static_cast<std::size_t>(frames(seconds)), 0.0); }

Samples gaussian(double seconds, double rms_db, unsigned seed = 1) {
  Samples noise = silence(seconds);
  std::mt19937 bits(seed);
  const auto uniform = [&] { return (static_cast<double>(bits()) + 0.5) / 4294967296.0; };
  for (double& x : noise)
    x = ratio(rms_db) * std::sqrt(-2 * std::log(uniform())) * std::cos(2 * std::numbers::pi * uniform());
  return noise;
}

struct Detected {
  std::vector<int> hits;  ///< frames
  double level = 0;       ///< at the end
};

struct Settings {
  double threshold = 0.02, hold_s = 0.015, mask_time_s = 0.020, high_pass_hz = 30;
};

Detected detect(const Samples& in, Settings settings = {}) {
  tactus_onset onset{};
  tactus_onset_start(&onset, kRate, settings.high_pass_hz, settings.mask_time_s, 0.028);
  Detected detected;
  for (std::size_t n = 0; n < in.size(); ++n)
    if (tactus_onset_step(&onset, in[n], settings.threshold, settings.hold_s, 1.41, 7) != 0)
      detected.hits.push_back(static_cast<int>(n));
  detected.level = onset.level;
  return detected;
}

}  // namespace

TEST_CASE("onset: a burst from silence is detected in its first frame above the threshold", "[dsp]") {
  Samples in = silence(0.3);
  const auto start = frames(0.1);
  SECTION("that is the first of a step") {
    strike(in, 0.1, 0.5, 2000, 0.01);
    CHECK(detect(in).hits == std::vector{start});
  }
  SECTION("and the fourth of a ramp of 0.006 a frame, for 0.02") {
    // The high-pass at 30 Hz takes 2 * 2 pi 30 / 48000 = 0.8 % of the first frames: 0.0238 stays above 0.02.
    for (int n = 0; n < 100; ++n) in[static_cast<std::size_t>(start + n)] = 0.006 * (n + 1);
    CHECK(detect(in).hits.at(0) == start + 3);
  }
}

TEST_CASE("onset: nothing is detected in silence and in DC", "[dsp]") {
  const double dc = GENERATE(0.0, 1.0, -0.3);
  CHECK(detect(Samples(48000, dc)).hits.empty());
}

TEST_CASE("onset: a soft hit 20 dB below a loud one is detected 60 ms after it", "[dsp]") {
  Samples in = silence(0.4);
  strike(in, 0.1, 0.5, 1500, 0.008);
  strike(in, 0.16, 0.05, 1500, 0.008);  // the loud one has decayed by 65 dB, the mask by 20 * 35 / 20 = 35
  CHECK(detect(in).hits == std::vector{frames(0.1), frames(0.16)});
}

TEST_CASE("onset: what a mask of 20 dB in 0.4 s covers is not detected", "[dsp]") {
  Samples in = silence(0.4);
  strike(in, 0.1, 0.5, 1500, 0.008);
  strike(in, 0.16, 0.05, 1500, 0.008);  // 20 dB lower; the mask has fallen by 20 * 35 / 400 = 1.75 dB
  CHECK(detect(in, {.mask_time_s = 0.4}).hits == std::vector{frames(0.1)});
}

TEST_CASE("onset: a ringing drum that beats is detected once", "[dsp]") {
  // Between 5 and 28 ms a hit must rise by 3.5 to 6.5 dB or more. Beats that fall and rise by 12 dB do less
  // than that while half a beat is longer than 28 ms (below 18 Hz); faster ones may be 6 dB deep.
  const auto [difference_hz, second] =
      GENERATE(std::pair{3.0, 0.3}, std::pair{8.0, 0.3}, std::pair{13.0, 0.3}, std::pair{21.0, 0.16},
               std::pair{35.0, 0.16});
  Samples in = silence(1.5);
  strike(in, 0.1, 0.5, 180, 0.3);
  strike(in, 0.1, second, 180 + difference_hz, 0.3);
  CHECK(detect(in).hits == std::vector{frames(0.1)});
}

TEST_CASE("onset: a second stroke on a ringing drum is detected", "[dsp]") {
  Samples in = silence(0.6);
  strike(in, 0.1, 0.4, 180, 0.3);
  strike(in, 0.1, 0.4, 2500, 0.003);
  strike(in, 0.2, 0.2, 180,
         0.3);  // 6 dB softer: less than what still rings of the first, 0.4 e^(-1/3) = 0.29
  strike(in, 0.2, 0.2, 2500, 0.003);
  CHECK(detect(in).hits == std::vector{frames(0.1), frames(0.2)});
}

TEST_CASE("onset: 30 equal hits a second are all detected, and `hold` is respected to the frame", "[dsp]") {
  Samples in = silence(1.2);
  for (int k = 0; k < 30; ++k) strike(in, 0.1 + k / 30.0, 0.5, 3000, 0.002);
  CHECK(detect(in).hits.size() == 30);
  CHECK(detect(in, {.hold_s = 0.040}).hits.size() == 15);  // one interval is 33.3 ms, two are 66.7

  const auto second = [](int frames_late) {
    Samples two = silence(0.3);
    strike(two, 0.1, 0.05, 2000, 0.01);
    strike(two, 0.15 + frames_late / kRate, 0.5, 2000, 0.001);
    return detect(two, {.hold_s = 0.050}).hits;
  };
  // What begins one frame before its end is no hit either, however loud.
  CHECK(second(0) == std::vector{4800, 7200});
  CHECK(second(-1) == std::vector{4800});
}

TEST_CASE("onset: steady noise above the threshold is learnt, and hits in it are detected", "[dsp]") {
  Samples in = gaussian(6.0, -50);
  strike(in, 5.0, ratio(-20), 2000, 0.01);
  // The noise passes -60 dB in most frames. Its peaks stay within 15 dB of its RMS: 5.6 sigma, once in 5e7
  // frames. It starts with a hit, because before it there was silence.
  const auto hits = detect(in, {.threshold = ratio(-60)}).hits;
  REQUIRE(hits.size() == 2);
  CHECK(hits[0] < frames(0.001));
  CHECK(hits[1] - frames(5.0) >= 0);
  CHECK(hits[1] - frames(5.0) < frames(0.0005));  // within the first period
}

TEST_CASE("onset: noise that follows digital silence is learnt too", "[dsp]") {
  Samples in = gaussian(10.0, -50);
  for (int n = 0; n < frames(1.0); ++n) in[static_cast<std::size_t>(n)] = 0;
  // From -100 dBFS the floor has 48 dB to rise to mean |y| = -52 dBFS, at 20 dB a second 2.4 s; the waits of
  // 0.1 s after each false hit, up to half the time, double that.
  const auto hits = detect(in, {.threshold = ratio(-60)}).hits;
  REQUIRE(!hits.empty());
  CHECK(hits.back() < frames(1 + 2 * 2.4));
}

TEST_CASE("onset: a long roll stays detected", "[dsp]") {
  Samples in = gaussian(11.0, -70);
  for (int k = 0; k < 200; ++k) strike(in, 0.5 + k / 20.0, 0.2, 1000, 0.02);
  CHECK(detect(in).hits.size() == 200);
}

TEST_CASE("onset: level is the peak of the hit within 1 dB", "[dsp]") {
  const double peak_db = GENERATE(0.0, -12.0, -30.0);
  const double hz = GENERATE(200.0, 1000.0, 5000.0);
  Samples in = silence(0.3);
  strike(in, 0.1, ratio(peak_db), hz, 0.05);
  CHECK(20 * std::log10(detect(in).level) == Approx(peak_db).margin(1));  // the goal for the instrument
}

TEST_CASE("onset: a woofer's own pulse is no hit if high_pass lies above it", "[dsp]") {
  // Cone: 35 g on 1000 N/m with 1.2 + 6^2 / 6.5 = 6.7 kg/s, driven by a pulse of 12 ms that starts `delay`
  // after each hit; its velocity reaches the microphone as loud as the stick's crack at 2.5 kHz.
  const double delay = GENERATE(0.0, 0.005, 0.010, 0.020, 0.030, 0.040);
  Samples in = silence(2.08 + delay);  // until before the pulse that no hit calls for
  double position = 0, velocity = 0;
  for (std::size_t n = 0; n < in.size(); ++n) {
    const double t = std::fmod(static_cast<double>(n) / kRate - 0.1 - delay + 10, 0.1);
    const bool on = static_cast<double>(n) / kRate >= 0.1 + delay;
    const double force = on ? std::exp(-t / 0.012) : 0;
    velocity += (force - 6.7 * velocity - 1000 * position) / 0.035 / kRate;
    position += velocity / kRate;
    in[n] = 3.0 * velocity;  // peaks near 0.3
  }
  for (int k = 0; k < 20; ++k) strike(in, 0.1 + 0.1 * k, 0.3, 2500, 0.001);
  const auto hits = detect(in, {.high_pass_hz = 500}).hits;
  REQUIRE(hits.size() == 20);
  for (int k = 0; k < 20; ++k)
    CHECK(std::abs(hits[static_cast<std::size_t>(k)] - frames(0.1 + 0.1 * k)) < frames(0.001));
}

}  // namespace tactus
