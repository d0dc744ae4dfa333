#include "engine/rig/actuator_figures.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <map>

using namespace tactus;

namespace {

const std::string kFader = R"(format = 1
name = "fader"
profile = "motorised_fader"
[price]
from = 30
to = 40
kind = "sheet"
source = "paper"
[force]
value = "2 N at 10 V"
at_most = "2 N"
kind = "judgement"
source = "estimate"
[band]
from = "0 Hz"
to = "2.7 Hz"
drive_to = "1.5 Hz"
kind = "derived"
source = "law"
[excursion]
at_most = "50 mm"
kind = "sheet"
source = "data sheet"
[resolution]
step = "0.098 mm"
kind = "derived"
source = "ten bits"
)";

std::string errors_of(const std::string& text) {
  const auto read = parse_actuator_figures(text, "fader.toml");
  return read ? "" : to_string(read.error());
}

}  // namespace

TEST_CASE("actuator figures: every number and source is read", "[rig]") {
  const auto figures = parse_actuator_figures(kFader, "fader.toml");
  REQUIRE(figures);
  CHECK(figures->name == "fader");
  CHECK(figures->profile == "motorised_fader");
  CHECK(figures->price.low == 30.0);
  CHECK(figures->price.high == 40.0);
  CHECK(figures->force.value == "2 N at 10 V");
  CHECK(figures->force.kind == ActuatorFigure::Kind::Judgement);
  CHECK(figures->force.high == 2.0);
  CHECK(figures->band.high == 2.7);
  CHECK(figures->drive_to == 1.5);
  CHECK(figures->excursion.high == Approx(0.05));
  CHECK(figures->resolution.low == Approx(0.098e-3));
}

TEST_CASE("actuator figures: sensors, and actuators without a sensor, are marked", "[rig]") {
  const auto figures = parse_actuator_figures(kFader, "fader.toml");
  REQUIRE(figures);
  CHECK_FALSE(figures->sensor);
  CHECK_FALSE(figures->no_sensor);
  auto text = kFader;
  text.replace(text.find("step = "), 17, "no_sensor = true");
  text.replace(text.find("profile = "), 0, "sensor = true\n");
  const auto marked = parse_actuator_figures(text, "sensor.toml");
  REQUIRE(marked);
  CHECK(marked->sensor);
  CHECK(marked->no_sensor);
}

TEST_CASE("actuator figures: what is wrong is an error with its place", "[rig]") {
  auto text = kFader;
  text.replace(text.find("at_most = \"2 N\""), 15, "at_most = \"2 m\"");
  CHECK(errors_of(text).find("fader.toml:11:") != std::string::npos);
  CHECK(errors_of("format = 1\n").find("name") != std::string::npos);
  CHECK(errors_of(kFader + "colour = \"red\"\n").find("colour") != std::string::npos);
}

TEST_CASE("actuator figures: what a file leaves out is unknown", "[rig]") {
  const auto figures = parse_actuator_figures("format = 1\nname = \"x\"\n", "x.toml");
  REQUIRE(figures);
  for (const auto* figure :
       {&figures->price, &figures->force, &figures->band, &figures->excursion, &figures->resolution})
    CHECK(figure->kind == ActuatorFigure::Kind::Unknown);
}

TEST_CASE("actuator figures: the ends of a band and of a price are in order", "[rig]") {
  auto text = kFader;
  text.replace(text.find("from = \"0 Hz\""), 13, "from = \"3 Hz\"");
  CHECK(errors_of(text).find("fader.toml:16:6: 'to' of [band] is below 'from'") != std::string::npos);
  text = kFader;
  text.replace(text.find("to = 40"), 7, "to = 20");
  CHECK(errors_of(text).find("fader.toml:6:6: 'to' of [price] is below 'from'") != std::string::npos);
}

TEST_CASE("actuator figures: of the shipped files each has a source, and prices are those of table 1",
          "[rig]") {
  // Berdahl, Steiner, Oldham, NIME 2008, table 1, in US $; of the row "Woofers/shaker" and the others the
  // price that it gives lies within that of each device.
  const std::map<std::string, std::pair<double, double>> table = {{"Vibrating motor", {1, 20}},
                                                                  {"Tactor", {5, 200}},
                                                                  {"Alps motorized fader", {30, 30}},
                                                                  {"Woofers/shaker", {40, 40}},
                                                                  {"Servomotor with encoder", {400, 400}},
                                                                  {"Novint Falcon", {200, 200}},
                                                                  {"SensAble Omni", {1000, 1000}}};
  std::map<std::string, int> found;
  const auto folder = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments/actuators/figures";
  for (const auto& entry : std::filesystem::directory_iterator{folder}) {
    const auto figures = load_actuator_figures(entry.path());
    INFO(entry.path());
    REQUIRE(figures);
    if (!figures->plant.empty()) CHECK(std::filesystem::exists(entry.path().parent_path() / figures->plant));
    for (const auto* figure :
         {&figures->price, &figures->force, &figures->band, &figures->excursion, &figures->resolution}) {
      CHECK_FALSE(figure->source.empty());
      if (!figure->value.empty())
        CHECK((figure->value == "unknown") == (figure->kind == ActuatorFigure::Kind::Unknown));
    }
    if (figures->row.empty()) continue;
    REQUIRE(table.contains(figures->row));
    ++found[figures->row];
    const auto [low, high] = table.at(figures->row);
    CHECK(figures->price.low <= low);
    CHECK(figures->price.high >= high);
  }
  CHECK(found.size() == table.size());
}
