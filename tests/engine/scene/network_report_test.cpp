#include "engine/scene/network_report.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/nodes/table.h"
#include "engine/scene/play_scene.h"
#include "tests/support/scene_folder.h"

using namespace tactus;
using namespace tactus::test;

namespace {

/// A mass of 10 g on a spring of 400 kN/m, 1006.6 Hz, and whatever else.
std::vector<NetworkReport> reports_of(const std::string& options, const std::string& more = "") {
  TemporaryFolder folder;
  folder.write("plant.toml", "format = 1\n[networks.n]\n" + options + R"(
frame = { type = "ground" }
tip = { type = "mass", mass = "10 g", at = "1 mm" }
hold = { type = "spring", between = ["frame", "tip"], stiffness = "400 kN/m" }
)" + more + "[outputs]\ntip = { from = \"n.tip.position\", unit = \"m\" }\n");
  folder.write("scene.toml",
               "format = 1\nname = \"swing\"\nduration = \"20 ms\"\n[parts]\nplant = { use = "
               "\"plant.toml\" }\n");
  const auto loaded = load_scene_leniently(folder.path());
  auto built = build_scene(loaded, standard_nodes());
  REQUIRE(built);
  SceneTimes times{*built, frames_in(loaded.scene->duration, 48_kHz)};
  REQUIRE(play_scene(*loaded.scene, *built, 64, {}, &times));
  return times.networks();
}

}  // namespace

TEST_CASE("network report: the bound is the error of the stiffest resonance, in one line with the time",
          "[scene]") {
  const auto networks = reports_of("solver = \"passive\"");
  REQUIRE(networks.size() == 1);
  const auto& network = networks.front();
  // (w T)^2 / 24 to the next order, which is smaller by (w T)^2 3/80.
  const double step = std::sqrt(400e3 / 0.01) / 48e3;
  REQUIRE(network.error_bound());
  CHECK(*network.error_bound() == Approx(step * step / 24).epsilon(0.01));
  REQUIRE(network.ns_per_frame);
  CHECK(*network.ns_per_frame > 0.0);
  const auto text = describe(network);
  CHECK(text.starts_with("network 'plant.n' in plant.toml: passive, error at most 0.072 %, "));
  CHECK(text.ends_with(" ns per frame"));
}

TEST_CASE("network report: what auto took is bounded as it chose it", "[scene]") {
  // Explicit steps at 1 kHz are off by 0.07 %.
  const auto network = reports_of("solver = \"auto\"").front();
  CHECK(network.solver == Solver::Explicit);
  CHECK(describe_bound(network) == "error at most 0.072 %");
}

TEST_CASE("network report: exact steps have no bound but rounding, and say how many there are", "[scene]") {
  const auto network = reports_of("solver = \"exact\"\noversample = 2").front();
  CHECK(describe_solver(network) == "exact x2");
  CHECK(describe_bound(network) == "no error beyond rounding");
  CHECK(network.error_bound() == 0.0);
}

TEST_CASE("network report: exact steps with friction have the bound of its force", "[scene]") {
  const auto network =
      reports_of("solver = \"exact\"",
                 "g = { type = \"ground\" }\n"
                 "r = { type = \"friction\", between = [\"g\", \"tip\"], normal = \"1 N\", kinetic = 0.3 }\n")
          .front();
  const double squared = 400e3 / 0.01 / 48e3 / 48e3;
  REQUIRE(network.error_bound());
  CHECK(*network.error_bound() == Approx(squared / 8.0).epsilon(1e-9));
  CHECK(
      describe_bound(network) ==
      "resonances exact, friction and plectra as if their forces were at most 0.22 % off, each stop and slip "
      "within 2 frames");
}

TEST_CASE("network report: what is unstable, and the reference, have no bound", "[scene]") {
  // k / (m fs^2) = 4.3 > 4
  const auto stiff = reports_of(
      "solver = \"explicit\"",
      "t = { type = \"mass\", mass = \"1 g\" }\ns = { type = \"spring\", between = [\"tip\", \"t\"], "
      "stiffness = \"1e7 N/m\" }\n");
  CHECK_FALSE(stiff.front().error_bound());
  CHECK(describe_bound(stiff.front()) == "error not bounded: unstable: springs or dampers too stiff");
  const auto reference = reports_of("solver = \"reference\"").front();
  CHECK_FALSE(reference.error_bound());
  CHECK(describe_bound(reference) == "the reference solution");
}
