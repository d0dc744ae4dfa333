#include <catch2/catch.hpp>
#include <string>

#include "apps/play/play_report.h"
#include "apps/study/study.h"
#include "tests/support/well_formed.h"

using namespace tactus;
using namespace tactus::app;

namespace {

WallMap small_map() {
  WallStudy study;
  study.devices = {{"bare", {.mass = 0.05, .damping = 0.1, .quantum = 0.15708e-3, .force_limit = 6.37}},
                   {"held", {.mass = 0.06, .damping = 5.1}}};
  study.controllers = controllers_of_the_paper();
  study.points_per_decade = 1;
  return *map_walls(study);
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("wall report: people, machines and pictures get the same map", "[apps]") {
  const auto map = small_map();
  const auto text = text_of(map);
  const auto row = text.substr(text.find("ATMEL 20 kHz 0.05 ms"));
  CHECK(contains(row.substr(0, row.find('\n')), " 1333 N/m"));
  CHECK(contains(text, "ATMEL computes with 16 bits: force in steps of 0.194 mN"));
  CHECK(contains(text, "Without dry friction"));
  CHECK(contains(text, "30 of 30 stability limits confirmed"));

  const auto json = json_of(map);
  CHECK(json["borders"] == 30);
  CHECK(json["confirmed"] == 30);
  CHECK(json["controllers"].size() == 6);
  CHECK(json["controllers"][1]["limits"]["bare"]["stiffest_n_per_m"].get<double>() ==
        Approx(66.7).epsilon(1e-3));
  CHECK(json["by_delay"]["held"].size() == 5);
  CHECK(json["devices"][1]["force_limit_n"].dump() == "null");  // JSON has no infinity

  const auto picture = to_svg(plots_of(map));
  CHECK(test::well_formed(picture));
  for (const auto& controller : map.controllers) CHECK(contains(picture, controller.name));
}

TEST_CASE("play report: a port that turned active says when, how much and how fast", "[apps]") {
  PortEnergy calm;
  calm.name = "arm";
  calm.allowed = 0.01;
  calm.given = 0.002;
  auto active = calm;
  active.given = 2;
  active.active_at_s = 0.25;
  active.growth_w = 1.5;
  const auto json = ports_json({calm, active});
  CHECK(json[0]["active"] == false);
  CHECK_FALSE(json[0].contains("active_at_s"));
  CHECK(json[1]["active"] == true);
  CHECK(json[1]["active_at_s"] == 0.25);
  CHECK(json[1]["growth_w"] == 1.5);
  CHECK(describe(active) ==
        "arm: the loop became active at 0.25 s: it delivered 2 J (0.01 J allowed), 1.5 W on average from "
        "then on");
}
