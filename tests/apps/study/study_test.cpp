#include "apps/study/study.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>

#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace tactus::app;

namespace {

/// Two runs that came out and one that did not.
WorkPrecision studied() {
  WorkPrecision study;
  study.scene = "swing";
  study.references = {{"pitch", "frequency", "plant.tip", "closed form"},
                      {"path", "position", "plant.tip", "integration from event to event", 1e-6}};
  WorkPoint cheap, close, wild;
  cheap.variant = {"explicit", 1, 48_kHz};
  cheap.errors = {1e-3, 2e-3};
  cheap.floors = {0.0, 1e-6};
  cheap.front = {true, true};
  cheap.ns_per_frame = 100.0;
  cheap.multiplications = 12.0;
  close.variant = {"passive", 16, 48_kHz};
  close.errors = {5e-5, 5e-6};
  close.floors = {0.0, 1e-6};
  close.front = {true, false};
  close.ns_per_frame = 1000.0;
  wild.variant = {"explicit", 1, 24_kHz};
  wild.unstable = true;
  study.points = {wild, close, cheap};
  return study;
}

}  // namespace

TEST_CASE("study: the table goes from the cheapest run on, and tells no error of an unstable one", "[apps]") {
  const auto text = text_of(studied());
  const auto cheap = text.find("1.00e-03 *"), close = text.find("5.00e-05 *"), wild = text.find("unstable");
  REQUIRE(cheap != std::string::npos);
  REQUIRE(close != std::string::npos);
  REQUIRE(wild != std::string::npos);
  CHECK(cheap < close);
  CHECK(close < wild);
  CHECK(text.find("5.00e-06?") != std::string::npos);  // not ten times the reference's own error
  CHECK(text.find("Within 1 %: explicit x 1 at 48 kHz, 100 ns per frame, 0.48 % of real time") !=
        std::string::npos);
  CHECK(text.find("Within 0.01 %: passive x 16 at 48 kHz") != std::string::npos);
}

TEST_CASE("study: the JSON has a verdict for each run, and null where there is no number", "[apps]") {
  const auto json = json_of(studied());
  REQUIRE(json["runs"].size() == 3);
  CHECK(json["runs"][0]["verdict"] == "ok");
  CHECK(json["runs"][0]["errors"]["pitch"] == 1e-3);
  CHECK(json["runs"][0]["nothing_cheaper_is_closer"]["path"] == true);
  CHECK(json["runs"][2]["verdict"] == "unstable");
  CHECK(json["runs"][2]["ns_per_frame"].is_null());
  CHECK(json["references"][1]["own_error"] == 1e-6);
}

TEST_CASE("study: each run is a row of the Markdown table", "[apps]") {
  const auto table = markdown_of(studied());
  CHECK(std::count(table.begin(), table.end(), '\n') == 5);
  CHECK(table.find("| explicit | 1 | 48 kHz | 12 | 100.0 | 0.48 % | 1.00e-03 \\* | 2.00e-03 \\* |") !=
        std::string::npos);
  CHECK(table.find("| explicit | 1 | 24 kHz |  |  |  | unstable |  |") != std::string::npos);
}

namespace {

const std::string kBall = std::string{TACTUS_SOURCE_DIR} + "/instruments/bouncing_ball/table_scene.toml";

/// Exit code and output of a study.
std::pair<int, std::string> study(const std::string& arguments) {
  const test::TemporaryFolder folder;
  const auto out = folder.path() / "out.txt";
  const auto command =
      std::string{TACTUS_PROGRAM} + " study " + arguments + " >" + out.string() + " 2>/dev/null";
  const int exit = std::system(command.c_str()) / 256;
  std::ifstream stream{out};
  return {exit, {std::istreambuf_iterator<char>{stream}, {}}};
}

}  // namespace

TEST_CASE("study bifurcation: a resumed study is the whole, byte for byte", "[apps]") {
  const test::TemporaryFolder folder;
  const std::string brief = "bifurcation " + kBall + " --settle 0.1 --read 0.3 --json ";
  const auto over = brief + "--over plant.gamma=1.3:1.5:14 ";
  const auto whole = study(over);
  CHECK(whole.first == 0);
  const auto keep = over + "--keep " + folder.path().string();
  CHECK(study(keep + " --part 2/2") == std::pair{0, std::string{}});
  CHECK(study(keep) == whole);
  CHECK(study(keep + " --workers 1") == whole);
  CHECK(study(brief + "--over plant.gamma=1.5:1.3:14").first == 2);
  CHECK(study(brief + "--over plant.gamma=1.3:1.5:14:log").first == 2);
  CHECK(study(brief + "--over 'plant.gamma=1:2:3 m'").first == 2);
}
