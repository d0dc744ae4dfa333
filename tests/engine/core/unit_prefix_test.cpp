#include <catch2/catch.hpp>
#include <string>

#include "engine/core/dimension.h"

TEST_CASE("unit_prefix: takes what is a unit and leaves the rest of the expression", "[graph]") {
  const auto [text, unit] = GENERATE(table<std::string, std::string>({
      {"ms", "ms"},
      {"ms * x", "ms"},
      {"N/m + 1", "N/m"},
      {"N / m", "N"},
      {"N s/m*v", "N s/m"},
      {"N/m/s", "N/m/s"},
      {"N/m^1.5-x", "N/m^1.5"},
      {"m/speed", "m"},
      {"1/m", "1/m"},
      {"1/speed", ""},
      {"%)", "%"},
      {"full scale", "full scale"},
      {"full scale_b", ""},
      {"s.low", ""},
      {"strength", ""},
      {"* x", ""},
      {"", ""},
  }));
  CHECK(tactus::unit_prefix(text) == unit);
}
