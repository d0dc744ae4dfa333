#include "engine/core/prefixed.h"

#include <catch2/catch.hpp>
#include <limits>

using tactus::prefixed;

TEST_CASE("prefixed: four digits and an SI prefix, no exponent", "[core]") {
  CHECK(prefixed(27372, "N/m") == "27.37 kN/m");
  CHECK(prefixed(2000, "N/m") == "2 kN/m");
  CHECK(prefixed(0.00011244, "J") == "112.4 uJ");
  CHECK(prefixed(-0.5, "s") == "-500 ms");
  CHECK(prefixed(0, "Hz") == "0 Hz");
  CHECK(prefixed(999.96, "Hz") == "1 kHz");
  CHECK(prefixed(1e10, "Hz") == "10 GHz");
  CHECK(prefixed(0.25, "") == "0.25");
  CHECK(prefixed(std::numeric_limits<double>::infinity(), "N") == "unlimited");
}
