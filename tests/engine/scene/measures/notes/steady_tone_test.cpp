#include <catch2/catch.hpp>
#include <cmath>

#include "engine/scene/measures/notes/pitch_track.h"

using namespace tactus;

namespace {

/// One moment after the other, from 1 s on.
std::vector<ToneMoment> moments(const std::vector<std::pair<double, double>>& off_and_rms) {
  std::vector<ToneMoment> all;
  for (const auto& [off, rms] : off_and_rms)
    all.push_back({1 + kPitchHop_s * static_cast<double>(all.size()), 110 * std::exp2(off / 1200), 110, rms});
  return all;
}

std::vector<std::pair<double, double>> held(int moments, double off, double rms) {
  return std::vector(static_cast<std::size_t>(moments), std::pair{off, rms});
}

}  // namespace

TEST_CASE("stands_at: a tone stands once it holds pitch and level for a tenth of a second", "[analysis]") {
  auto all = held(9, 0, 1);  // a moment too few
  all.emplace_back(60, 1);
  for (const auto& more : held(10, 45, 0.2)) all.push_back(more);  // within 50 cents and 15 dB
  const auto steady = steady_from(moments(all), 0, 1);
  REQUIRE(steady);
  CHECK(*steady == Approx(1.1));
  CHECK_FALSE(steady_from(moments(held(30, 0, 0.15)), 0, 1));  // 16.5 dB too soft
  CHECK_FALSE(steady_from(moments(held(30, 55, 1)), 0, 1));
  CHECK(steady_from(moments(held(5, 0, 1)), 0, 1, 0.05));
}

TEST_CASE("stands_at: a moment without a pitch begins it anew", "[analysis]") {
  auto all = moments(held(19, 0, 1));
  all.erase(all.begin() + 9);
  CHECK_FALSE(steady_from(all, 0, 1));
  CHECK(steady_from(moments(held(19, 0, 1)), 0, 1));
}

TEST_CASE("partial_of: the partial within 50 cents, or none", "[analysis]") {
  CHECK(partial_of(331, 110) == 3);
  CHECK(partial_of(110 * std::exp2(49.0 / 1200), 110) == 1);
  CHECK(partial_of(110 * std::exp2(51.0 / 1200), 110) == 0);
  CHECK(partial_of(55, 110) == 0);
}

TEST_CASE("swing_of: the middle nine tenths, so that a stray moment is none of it", "[analysis]") {
  std::vector<double> hertz(40, 220.0);
  hertz[3] = 440;
  CHECK(swing_of(hertz) == 0);
  for (std::size_t i = 0; i < 20; ++i) hertz[2 * i] = 220 * std::exp2(30.0 / 1200);
  CHECK(swing_of(hertz) == Approx(30));
  CHECK(swing_of({}) == 0);
}
