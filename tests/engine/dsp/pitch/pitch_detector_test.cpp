#include "engine/dsp/pitch/pitch_detector.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/graphs/node_runner.h"

using namespace tactus;

namespace {

constexpr Hertz kRate{48000};

/// Partials of `hertz` with these heights, half a second of them.
test::Samples tone(double hertz, const std::vector<double>& partials, double seconds = 0.5) {
  test::Samples x(static_cast<std::size_t>(seconds * kRate.value));
  for (std::size_t n = 0; n < x.size(); ++n)
    for (std::size_t h = 0; h < partials.size(); ++h)
      x[n] += partials[h] *
              std::sin(2 * std::numbers::pi * static_cast<double>((h + 1) * n) * hertz / kRate.value +
                       0.3 * static_cast<double>(h));
  return x;
}

/// All that is found has this pitch within `most` cents, and it is found everywhere but at the ends, where
/// the windows of six periods do not fit.
void check_pitch(const test::Samples& x, double hertz, double most = 0.1) {
  const auto points = track_pitch(x, kRate, 50_Hz, 1500_Hz);
  const double seconds = static_cast<double>(x.size()) / kRate.value - 7 / hertz - 0.02;
  CHECK(static_cast<double>(points.size()) >= 100 * seconds);
  for (const auto& point : points) {
    INFO(point.time_s << " s: " << point.hertz);
    CHECK(std::abs(cents(point.hertz, hertz)) < most);
  }
}

/// A square wave: odd partials falling as 1/h.
std::vector<double> square() {
  std::vector<double> heights(15, 0.0);
  for (std::size_t h = 1; h <= heights.size(); h += 2) heights[h - 1] = 1.0 / static_cast<double>(h);
  return heights;
}

}  // namespace

TEST_CASE("pitch_track: a sine is found within 0.1 cent", "[dsp]") {
  const double hertz = GENERATE(65.406, 110.0, 110.0 * 1.0057929, 220.3, 441.7, 987.77, 1318.5);
  check_pitch(tone(hertz, {0.5}), hertz);
}

TEST_CASE("pitch_track: a saw, a square and a tone without its fundamental keep their pitch", "[dsp]") {
  const double hertz = GENERATE(82.41, 146.83, 329.63, 659.26);
  check_pitch(tone(hertz, {1, 0.5, 0.333, 0.25, 0.2, 0.167, 0.143}), hertz);
  check_pitch(tone(hertz, square()), hertz);
  check_pitch(tone(hertz, {0, 0.6, 0.5, 0.4, 0.3}), hertz);
}

TEST_CASE("pitch_track: the strongest partial is named beside the pitch", "[dsp]") {
  auto heights = square();
  heights[2] = 1.5;
  for (const auto& point : track_pitch(tone(220, heights), kRate, 50_Hz, 1500_Hz)) {
    CHECK(std::abs(cents(point.hertz, 220)) < 0.1);
    CHECK(point.partial == 3);
  }
  for (const auto& point : track_pitch(tone(220, square()), kRate, 50_Hz, 1500_Hz)) CHECK(point.partial == 1);
  // The third partial alone is another note: its own.
  check_pitch(tone(220, {0, 0, 1}), 660);
}

TEST_CASE("pitch_track: a tone in noise 40 dB below it stays within 2 cents", "[dsp]") {
  auto x = tone(220, {0.5, 0.2});
  const auto hiss = test::noise(static_cast<int>(x.size()), 3, -0.005, 0.005);
  for (std::size_t n = 0; n < x.size(); ++n) x[n] += hiss[n];
  check_pitch(x, 220, 2);
}

TEST_CASE("pitch_track: a glide is followed", "[dsp]") {
  // Phase 2 pi (200 t + 20 t^2): the frequency is 200 + 40 t.
  test::Samples x(48000);
  for (std::size_t n = 0; n < x.size(); ++n) {
    const double t = static_cast<double>(n) / kRate.value;
    x[n] = std::sin(2 * std::numbers::pi * (200 * t + 20 * t * t));
  }
  const auto points = track_pitch(x, kRate, 50_Hz, 1500_Hz);
  REQUIRE(points.size() > 80);
  for (const auto& point : points) CHECK(std::abs(cents(point.hertz, 200 + 40 * point.time_s)) < 1);
}

TEST_CASE("pitch_track: silence, a constant and noise have no pitch", "[dsp]") {
  CHECK(track_pitch(test::Samples(24000, 0.0), kRate, 50_Hz, 1500_Hz).empty());
  CHECK(track_pitch(test::noise(24000, 5), kRate, 50_Hz, 1500_Hz).empty());
  CHECK(track_pitch(test::Samples{}, kRate, 50_Hz, 1500_Hz).empty());
  CHECK(track_pitch(test::Samples(24000, 0.7), kRate, 50_Hz, 1500_Hz).empty());
}

TEST_CASE("pitch_track: what is 60 dB below the loudest is silence", "[dsp]") {
  auto x = tone(220, {0.5}, 1.0);
  for (std::size_t n = 24000; n < x.size(); ++n) x[n] *= 1e-4;
  const auto points = track_pitch(x, kRate, 50_Hz, 1500_Hz);
  REQUIRE_FALSE(points.empty());
  CHECK(points.back().time_s < 0.53);
}
