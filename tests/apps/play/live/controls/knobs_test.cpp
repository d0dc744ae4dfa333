#include "apps/play/live/controls/knobs.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/graph_runner.h"

using namespace tactus;
using app::Knobs;

namespace {

const std::string kGraph = R"(
format = 1
[controls]
plain = { value = 0.5, range = [-1, 3] }
loud  = { value = "-30 dB", range = ["-60 dB", "0 dB"] }
[outputs]
y = { from = "plain" }
z = { from = "loud" }
)";

}  // namespace

TEST_CASE("knobs: a knob goes over its range, in decibels where the control does", "[live]") {
  const auto engine = test::engine_of(kGraph);
  Knobs knobs{*engine};
  REQUIRE(knobs.all().size() == 2);
  CHECK(knobs.place(0) == Approx((0.5 + 1) / 4));
  CHECK(knobs.place(1) == Approx(0.5));
  REQUIRE(knobs.turn(1, 0.75));
  CHECK(20 * std::log10(knobs.all()[1].control.value) == Approx(-15.0));
  CHECK(knobs.text(1) == "loud = -15 dB");
  REQUIRE(knobs.nudge(0, 0.25));
  CHECK(knobs.all()[0].control.value == Approx(1.5));
}

TEST_CASE("knobs: a knob stops at its ends", "[live]") {
  const auto engine = test::engine_of(kGraph);
  Knobs knobs{*engine};
  REQUIRE(knobs.nudge(0, 7.0));
  CHECK(knobs.all()[0].control.value == 3.0);
  REQUIRE(knobs.nudge(0, -7.0));
  CHECK(knobs.all()[0].control.value == -1.0);
}

TEST_CASE("knobs: the engine hears what is turned", "[live]") {
  const auto engine = test::engine_of(kGraph);
  Knobs knobs{*engine};
  REQUIRE(knobs.turn(0, 1.0));
  const auto out = test::run(*engine, {}, 1000, {64});
  CHECK(out[0][999] == 3.0);
}
