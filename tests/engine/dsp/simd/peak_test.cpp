#include "engine/dsp/simd/peak.h"

#include <catch2/catch.hpp>
#include <limits>
#include <vector>

using namespace tactus;

TEST_CASE("highest magnitude: a sample counts wherever it is, and with either sign") {
  for (int count = 1; count <= 20; ++count)
    for (int place = 0; place < count; ++place)
      for (const double sample : {3.0, -3.0}) {
        std::vector<double> samples(static_cast<std::size_t>(count), -1.0);
        samples[static_cast<std::size_t>(place)] = sample;
        CHECK(highest_magnitude(samples.data(), count, 2.0) == 3.0);
        CHECK(highest_magnitude(samples.data(), count, 4.0) == 4.0);
      }
}

TEST_CASE("highest magnitude: a NaN does not count") {
  for (int count = 1; count <= 20; ++count) {
    std::vector<double> samples(static_cast<std::size_t>(count), std::numeric_limits<double>::quiet_NaN());
    samples.back() = -0.5;
    CHECK(highest_magnitude(samples.data(), count, 0.25) == 0.5);
  }
}
