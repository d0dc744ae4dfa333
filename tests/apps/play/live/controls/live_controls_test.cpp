#include "apps/play/live/controls/live_controls.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/graphs/graph_runner.h"

using namespace tactus;
using app::LiveControls;

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

TEST_CASE("live controls: one goes over its range, in decibels where the control does", "[live]") {
  const auto engine = test::engine_of(kGraph);
  LiveControls controls{*engine};
  REQUIRE(controls.all().size() == 2);
  CHECK(controls.position(0) == Approx((0.5 + 1) / 4));
  CHECK(controls.position(1) == Approx(0.5));
  REQUIRE(controls.turn(1, 0.75));
  CHECK(20 * std::log10(controls.all()[1].control.value) == Approx(-15.0));
  CHECK(controls.text(1) == "loud = -15 dB");
  REQUIRE(controls.nudge(0, 0.25));
  CHECK(controls.all()[0].control.value == Approx(1.5));
}

TEST_CASE("live controls: one stops at its ends", "[live]") {
  const auto engine = test::engine_of(kGraph);
  LiveControls controls{*engine};
  REQUIRE(controls.nudge(0, 7.0));
  CHECK(controls.all()[0].control.value == 3.0);
  REQUIRE(controls.nudge(0, -7.0));
  CHECK(controls.all()[0].control.value == -1.0);
}

TEST_CASE("live controls: the engine receives the value", "[live]") {
  const auto engine = test::engine_of(kGraph);
  LiveControls controls{*engine};
  REQUIRE(controls.turn(0, 1.0));
  const auto out = test::run(*engine, {}, 1000, {64});
  CHECK(out[0][999] == 3.0);
}
