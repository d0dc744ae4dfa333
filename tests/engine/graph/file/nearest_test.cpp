#include <catch2/catch.hpp>
#include <vector>

#include "engine/graph/file/error_list.h"

using tactus::nearest_name;

TEST_CASE("nearest_name: finds what was meant", "[graph]") {
  const std::vector<std::string> types{"lowpass", "bandpass", "highpass", "delay", "decay", "gain"};
  CHECK(nearest_name("lowpas", types) == "lowpass");
  CHECK(nearest_name("lwopass", types) == "lowpass");
  CHECK(nearest_name("LowPass", types) == "lowpass");
  CHECK(nearest_name("dealy", types) == "delay");  // one swap; "decay" is two letters away
  CHECK(nearest_name("gains", types) == "gain");
}

TEST_CASE("nearest_name: knows a name by its first letters, if no other begins so", "[graph]") {
  const std::vector<std::string> inputs{"frequency", "phase", "level", "phasor"};
  CHECK(nearest_name("freq", inputs) == "frequency");
  CHECK(nearest_name("pha", inputs).empty());
  CHECK(nearest_name("fr", inputs).empty());
}

TEST_CASE("nearest_name: says nothing when nothing is near", "[graph]") {
  const std::vector<std::string> types{"lowpass", "gain", "y"};
  CHECK(nearest_name("ramp", types).empty());
  CHECK(nearest_name("x", types).empty());
  CHECK(nearest_name("", types).empty());
  CHECK(nearest_name(std::string(1 << 20, 'a'), types).empty());
  CHECK(nearest_name("gain", {}).empty());
}

TEST_CASE("nearest_name: the first of equals", "[graph]") {
  const std::vector<std::string> names{"tone_a", "tone_b"};
  CHECK(nearest_name("tone_c", names) == "tone_a");
}
