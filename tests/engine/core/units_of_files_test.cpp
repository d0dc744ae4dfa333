#include <catch2/catch.hpp>
#include <string>

#include "engine/core/dimension.h"
#include "tests/support/graphs/graph_runner.h"

using namespace tactus;

TEST_CASE("units: what files write is the SI value", "[core]") {
  const auto [text, si, unit] = GENERATE(table<std::string, double, std::string>({
      {"6 \u00B5s", 6e-6, "s"},
      {"6 \u03BCs", 6e-6, "s"},
      {"6 us", 6e-6, "s"},
      {"3 \u00B5m/s", 3e-6, "m/s"},
      {"120 bpm", 2, "Hz"},
      {"120 rpm", 2, "Hz"},
      {"6.25 rad/s", 6.25, "rad/s"},
      {"180 deg/s", 3.141592653589793, "rad/s"},
      {"90 deg", 1.5707963267948966, "rad"},
      {"2 N m/rad", 2, "N m/rad"},
      {"2 N m", 2, "N m"},
      {"2 mN m", 2e-3, "N m"},
      {"3 kg m^2", 3, "kg m^2"},
      {"2 J", 2, "J"},
      {"1200 cents", 2, ""},
      {"-1200 cents", 0.5, ""},
      {"12 semitones", 2, ""},
      {"1 semitone", 1.0594630943592953, ""},
      {"20 dB", 10, ""},
  }));
  INFO(text);
  const auto quantity = parse_quantity(text);
  REQUIRE(quantity);
  CHECK(quantity->si == Approx(si).epsilon(1e-15));
  CHECK(to_string(quantity->unit.dimension) == unit);
}

TEST_CASE("units: a ratio of frequencies is a factor in an expression", "[core]") {
  CHECK(test::errors_of("format = 1\n[nodes]\na = { type = \"sine\", frequency = \"440 Hz * 7 semitones\" }\n"
                        "b = { type = \"sine\", frequency = \"120 bpm + 6 rad/s\" }\n"
                        "[outputs]\nz = { from = \"a + b\" }\n") == "");
  CHECK_FALSE(parse_unit("cents/s"));
}

TEST_CASE("units: where only the case of letters is wrong the remedy names the unit", "[core]") {
  CHECK(meant_unit("KHZ") == "kHz");
  CHECK(meant_unit("hz") == "Hz");
  CHECK(meant_unit("MS") == "ms");
  CHECK(meant_unit("DB") == "dB");
  CHECK(meant_unit("n/M") == "N/m");
  CHECK(meant_unit("furlong") == "");
  CHECK(meant_unit("msec") == "ms");
  CHECK(meant_unit("Seconds") == "s");
  CHECK(meant_unit("kilohertz") == "kHz");
  const auto remedy = [](const std::string& value) {
    const auto compiled = compile(
        parse_graph_leniently("format = 1\n[controls]\nf = { value = \"1 kHz\", range = [\"0 Hz\", " + value +
                                  "] }\n[nodes]\na = { type = \"sine\", frequency = " + value + " }\n",
                              "test.toml"),
        standard_nodes(), {});
    std::string remedies;
    for (const auto& error : compiled.error()) remedies += error.remedy + "; ";
    return remedies;
  };
  CHECK(remedy("\"6 KHZ\"") == "did you mean kHz?; did you mean kHz?; ");
}
