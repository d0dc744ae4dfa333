#include "backends/second_device/timed_values.h"

#include <catch2/catch.hpp>
#include <random>

using namespace tactus;

TEST_CASE("timed values: between two points a value moves in a straight line, after the last one it rests") {
  TimedValues line;
  for (int n = 0; n < 20; ++n) line.write({0.001 * n, {2.0 * n, -1.0 * n}});
  for (const double seconds : {0.0, 0.0004, 0.0005, 0.0071, 0.0189}) {
    line.advance(seconds);
    CHECK(line.at(0, seconds) == Approx(2000 * seconds).margin(1e-12));
    CHECK(line.at(1, seconds) == Approx(-1000 * seconds).margin(1e-12));
  }
  line.advance(1.0);
  CHECK(line.at(0, 1.0) == 38.0);
  CHECK(line.newest() == 0.019);
}

TEST_CASE("timed values: before the first point they are zero, and the first counts at once") {
  TimedValues line;
  line.advance(1.0);
  CHECK(line.at(0, 1.0) == 0.0);
  line.write({1.5, {3.0}});
  line.advance(1.2);
  CHECK(line.at(0, 1.2) == 3.0);
}

TEST_CASE("block clock: blocks come up to a millisecond late, their frames do not") {
  // Mean lateness 0.5 ms. Each block takes a twentieth of its difference: a standard deviation of
  // 0.29 ms / sqrt(39) = 0.046 ms remains.
  std::mt19937 random{7};
  std::uniform_real_distribution<double> late{0.0, 0.001};
  BlockClock clock{48000};
  double worst = 0.0;
  for (int n = 0; n < 4000; ++n) {
    const double ideal = n * 64 / 48000.0;
    const double error = clock.start(ideal + late(random), 64) - ideal - 0.0005;
    if (n > 200) worst = std::max(worst, std::abs(error));
  }
  CHECK(worst < 5 * 0.046e-3);
  CHECK(clock.start(100.0, 64) == 100.0);  // after a pause
}
