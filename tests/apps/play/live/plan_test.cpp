#include "apps/play/live/plan.h"

#include <catch2/catch.hpp>

#include "apps/cli/commands.h"

using namespace tactus;

TEST_CASE("plan: a simulated world is not recorded, which is said before any device is looked for",
          "[live]") {
  app::LiveOptions options;
  options.target = "nowhere";
  options.listen = true;
  options.record = "take.wav";
  options.backend = "none of this name";
  const auto plan = app::make_plan(options);
  REQUIRE_FALSE(plan);
  CHECK(plan.error().exit == app::kUsage);
  REQUIRE(plan.error().errors.size() == 1);
  CHECK(to_string(plan.error().errors.front()) ==
        "--record: does not go with --listen; tactus play without --listen writes what a scene does");

  options.record.clear();  // what would have been complained about otherwise
  const auto other = app::make_plan(options);
  REQUIRE_FALSE(other);
  CHECK(other.error().errors.front().where == "--backend");
}
