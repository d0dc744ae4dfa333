#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/dsp/pitch/pitch_detector.h"
#include "tests/support/graphs/node_runner.h"

using namespace tactus;
using test::Samples;

namespace {

constexpr double kRate = 48000;

/// A tone with partials 1 to 8 of amplitude 1/k in phases of their own, with noise and an offset.
Samples tone(double hertz, int frames, double noise, double offset = 0) {
  auto samples = test::noise(frames, 11, -noise, noise);
  for (int n = 0; n < frames; ++n)
    for (int k = 1; k <= 8; ++k)
      samples[static_cast<std::size_t>(n)] +=
          offset / 8 + std::sin(2 * std::numbers::pi * k * hertz * n / kRate + k * k) / k;
  return samples;
}

test::Outputs follow(const Samples& in) {
  test::NodeRunner runner(test::node_type("pitch"), {{"in", in}});
  REQUIRE(runner.error().empty());
  return runner.run(test::random_cutting(static_cast<int>(in.size()), 3));
}

}  // namespace

TEST_CASE("pitch: of steady tones within 2 cents, also with an offset, and steps within 2 periods and 5 ms",
          "[nodes]") {
  for (const double hertz : {61.0, 82.41, 110.0, 233.1, 440.0, 783.99, 997.0}) {
    INFO(hertz);
    const auto out = follow(tone(hertz, 9600, 0, 0.3));
    CHECK(std::abs(cents(out[0].back(), hertz)) < 2);
    CHECK(out[1].back() == 1);
    CHECK(out[2].back() > 0.99);
  }
  // From 150 Hz to 200 Hz: right 2 periods of 5 ms, the window beyond (2.7 ms) and a hop of 5 ms later.
  auto change = tone(150, 9600, 0);
  const auto higher = tone(200, 4800, 0);
  std::copy(higher.begin(), higher.end(), change.begin() + 4800);
  const auto out = follow(change)[0];
  CHECK(std::abs(cents(out[4799], 150)) < 2);
  CHECK(std::abs(cents(out[4800 + 900], 200)) < 5);
}

TEST_CASE("pitch: 30 dB of noise below the tone moves it by less than 15 cents", "[nodes]") {
  for (const double hertz : {82.41, 220.0, 659.3}) {
    INFO(hertz);
    const auto out = follow(tone(hertz, 24000, 0.05));
    for (std::size_t n = 4800; n < out[0].size(); n += 240) CHECK(std::abs(cents(out[0][n], hertz)) < 15);
  }
}

TEST_CASE("pitch: noise and silence have none, and the last pitch is held", "[nodes]") {
  auto in = tone(220, 9600, 0);
  const auto noise = test::noise(24000, 5);
  in.insert(in.end(), noise.begin(), noise.end());
  in.resize(in.size() + 9600);
  const auto out = follow(in);
  int voiced = 0;
  for (std::size_t n = 14400; n < 33600; ++n) voiced += out[1][n] > 0;
  CHECK(voiced < 960);  // 5 % of the noise
  CHECK(out[1].back() == 0);
  CHECK(out[2].back() == 0);
  CHECK(follow(Samples(4800, 0.5))[0].back() == 0);
}
