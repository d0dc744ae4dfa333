#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "backends/loop/loop_path.h"

using namespace tactus;

TEST_CASE("sinc_line: up to 0.42 of the rate a fraction is right to 1e-5 frames and 1e-4 dB", "[loop]") {
  const double turns = GENERATE(0.001, 0.02, 0.1, 0.25, 0.35, 0.42);
  const double fraction = GENERATE(0.0001, 0.25, 0.5, 0.7301);
  CAPTURE(turns, fraction);
  constexpr std::int64_t kFrames = 2000;
  const double w = 2 * std::numbers::pi * turns;
  SincLine cosine{kFrames}, sine{kFrames};
  for (std::int64_t n = 0; n < kFrames; ++n) {
    cosine.add(n, std::cos(w * static_cast<double>(n)));
    sine.add(n, std::sin(w * static_cast<double>(n)));
  }
  for (const std::int64_t at : {500, 777, 1203}) {
    const std::complex<double> read{cosine.read(at, fraction), sine.read(at, fraction)};
    const auto error = read * std::polar(1.0, -w * (static_cast<double>(at) + fraction));
    CHECK(std::abs(std::arg(error)) <= 1e-5 * w + 1e-9);
    CHECK(std::abs(std::abs(error) - 1.0) <= 1.15e-5);  // 1e-4 dB
  }
}

TEST_CASE("sinc_line: whole frames are exact, and what was forgotten is silent", "[loop]") {
  SincLine line{100};
  line.add(7, 0.3);
  line.add(7, 0.1);
  CHECK(line.read(7, 0.0) == 0.3 + 0.1);
  CHECK(line.read(8, 0.0) == 0.0);
  line.forget(7);
  CHECK(line.read(7, 0.0) == 0.0);
  CHECK(line.read(7, 0.5) == 0.0);
}
