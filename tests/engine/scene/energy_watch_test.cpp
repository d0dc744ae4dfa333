#include "engine/scene/energy_watch.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include "engine/nodes/table.h"
#include "engine/scene/measures/measure.h"
#include "engine/scene/play_scene.h"
#include "tests/support/allocation_count.h"
#include "tests/support/error_summary.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/scene_folder.h"
#include "tests/support/wall_theory.h"

using namespace tactus;

namespace {

/// An arm that is pushed about, and an instrument that holds it with a spring: 100 N/m, b = 0.5 N s/m, 50 g.
/// At a delay tau the loop is stable while 100 N/m < 0.5 / tau: up to 5 ms, without the converters' half
/// frame.
struct SpringScene : test::TemporaryFolder {
  SpringScene() {
    write("instrument.toml", R"(format = 1
[inputs]
arm = { unit = "m" }
[nodes]
hold = { type = "spring", in = "arm", stiffness = "100 N/m" }
[outputs]
motor = { from = "hold / 10 N" }
)");
    write("plant.toml", R"(format = 1
[inputs]
drive = { unit = "full scale" }
push = { unit = "N" }
[networks.p]
frame = { type = "ground" }
arm = { type = "mass", mass = "50 g" }
bearing = { type = "damper", between = ["frame", "arm"], damping = "0.5 N s/m" }
motor = { type = "force", on = "arm", force = "10 N * drive" }
hand = { type = "force", on = "arm", force = "push" }
[outputs]
arm = { from = "p.arm.position", unit = "m" }
speed = { from = "p.arm.velocity", unit = "m/s" }
force = { from = "p.motor", unit = "N" }
)");
  }

  std::string text(const std::string& delay, const std::string& ports, const std::string& expect) const {
    return fmt::format(
        "format = 1\nduration = \"4 s\"\ndelay = \"{}\"\nconverters = {{ off = true }}\n[parts]\n"
        "instrument = {{ use = \"instrument.toml\", arm = \"plant.arm\" }}\n"
        "plant = {{ use = \"plant.toml\", drive = \"instrument.motor\", push = \"shove\" }}\n"
        "[drives]\n[gestures]\n"
        "shove = {{ points = [[\"0 s\", \"0 N\"], [\"0.1 s\", \"1 N\"], [\"0.4 s\", \"-0.6 N\"], [\"1 s\", "
        "\"0 N\"]] "
        "}}\n[ports]\n{}\n[expect]\n{}\n",
        delay, ports, expect);
  }
  Checked<BuiltScene> build(const std::string& scene) const {
    return build_scene(parse_scene_leniently(scene, (path() / "scene.toml").generic_string(), path()),
                       standard_nodes());
  }
  SceneRecording play(const std::string& scene, int block = 64) const {
    auto spec = test::parse_scene(scene, (path() / "scene.toml").generic_string(), path());
    if (!spec) throw std::runtime_error(to_string(spec.error()));
    auto built = build(scene);
    if (!built) throw std::runtime_error(to_string(built.error()));
    return *play_scene(*spec, *built, block);
  }
};

const std::string kArm = R"(arm = { force = "plant.force", position = "plant.arm", active_up_to = "10 mJ" })";

EnergyWatch watch_allowing(double joules) {
  Port port;
  port.allowed = joules;
  return EnergyWatch{port};
}

PortEnergy watch(const std::vector<double>& force, const std::vector<double>& position, double allowed) {
  auto energy = watch_allowing(allowed);
  energy.take(force.data(), position.data(), static_cast<int>(force.size()));
  return energy.energy(1_kHz);
}

}  // namespace

TEST_CASE("energy_watch: a held force does force times way, and the lowest moment counts", "[scene]") {
  // Takes 3 J, gives 5 J, takes 1 J.
  const auto energy = watch({9, -1, 2.5, 0.5}, {0, 3, 5, 3}, 4);
  CHECK(energy.net == 1);
  CHECK(energy.given == 5);
  REQUIRE(energy.active_at_s);
  CHECK(*energy.active_at_s == 2e-3);
  CHECK(energy.growth_w == 0);
  CHECK_FALSE(watch({9, -1, 2.5, 0.5}, {0, 3, 5, 3}, 5).active_at_s);
}

TEST_CASE("energy_watch: growth is the mean power from the moment it turned active", "[scene]") {
  // 1 N along 1 mm a frame at 1 kHz: 1 W. Allowed are 10 mJ, so the eleventh step is too much.
  std::vector<double> force(101, 1.0), position(101);
  for (int n = 0; n <= 100; ++n) position[static_cast<std::size_t>(n)] = 1e-3 * n;
  const auto energy = watch(force, position, 10.5e-3);
  CHECK(*energy.active_at_s == Approx(11e-3));
  CHECK(energy.growth_w == Approx(1.0));
  CHECK(describe(energy).find("became active at 0.011 s") != std::string::npos);
}

TEST_CASE("energy_watch: pieces of any length add up to the same, and nothing allocates", "[scene]") {
  std::mt19937 random{1};
  std::normal_distribution<double> normal;
  std::vector<double> force(1000), position(1000);
  for (auto& f : force) f = normal(random);
  for (auto& x : position) x = normal(random);
  auto pieces = watch_allowing(0.1);
  const auto allocations = test::allocation_count();
  for (std::size_t at = 0, size = 1; at < 1000; at += size, size = 1 + (size * 7) % 50) {
    size = std::min(size, 1000 - at);
    pieces.take(force.data() + at, position.data() + at, static_cast<int>(size));
  }
  CHECK(test::allocation_count() == allocations);
  const auto whole = watch(force, position, 0.1), cut = pieces.energy(1_kHz);
  CHECK(cut.net == whole.net);
  CHECK(cut.given == whole.given);
  CHECK(cut.active_at_s == whole.active_at_s);
}

TEST_CASE(
    "energy_watch: a spring without delay never gives more than it stores, one behind 20 ms without end",
    "[scene]") {
  const SpringScene scene;
  const auto passive = scene.play(scene.text("0 ms", kArm, ""));
  REQUIRE(passive.ports.size() == 1);
  const auto& arm = passive.find("plant.arm")->samples;
  double stored = 0;
  for (const double x : arm) stored = std::max(stored, 0.5 * 100 * x * x);
  REQUIRE(stored > 1e-3);
  // The held force lags by half a frame, 10 us: pi K X^2 w T/2 is a thousandth of what is stored.
  CHECK(passive.ports[0].given < 1.005 * stored);
  CHECK(passive.ports[0].net < 1e-3 * stored);
  CHECK_FALSE(passive.ports[0].active_at_s);

  const auto active = scene.play(scene.text("20 ms", kArm, ""));
  CHECK(active.ports[0].given > 50 * stored);  // until the guard ended it
  REQUIRE(active.ports[0].active_at_s);
  CHECK(*active.ports[0].active_at_s < 2);
  CHECK(active.ports[0].growth_w > 0.1);
}

// No guard: from here to the window of a second later the energy grows as the square of the swing does.
TEST_CASE("energy_watch: an unstable loop gives without bound, as fast as its root says", "[scene]") {
  CompileOptions options;
  options.sample_rate = 10_kHz;
  const auto engine = test::engine_of(R"(format = 1
[networks.p]
frame = { type = "ground" }
arm = { type = "mass", mass = "50 g", at = "1 mm" }
bearing = { type = "damper", between = ["frame", "arm"], damping = "0.5 N s/m" }
motor = { type = "force", on = "arm", force = "late" }
[nodes]
hold = { type = "spring", in = "p.arm.position", stiffness = "300 N/m" }
late = { type = "delay", in = "hold", time = "2 ms", interpolation = "none" }
[outputs]
force = { from = "p.motor.force", unit = "N" }
arm = { from = "p.arm.position", unit = "m" }
)",
                                      options);
  const auto out = test::run(*engine, {}, 50000, {256});
  const auto given_until = [&](double seconds) {
    auto energy = watch_allowing(1e-3);
    energy.take(out[0].data(), out[1].data(), static_cast<int>(seconds * 1e4));
    return energy.energy(options.sample_rate).given;
  };
  const WallDevice device{.mass = 0.05, .damping = 0.5};
  const double per_frame = std::log(test::largest_root(device, {10_kHz, 2_ms}, 300));
  CHECK(given_until(5) / given_until(4) == Approx(std::exp(2 * per_frame * 1e4)).epsilon(0.05));
  CHECK(given_until(5) > 4 * given_until(4));
}

TEST_CASE("energy_watch: how a scene is cut into blocks changes no bit", "[scene]") {
  const SpringScene scene;
  const auto text = scene.text("5 ms", kArm, "");
  const auto one = scene.play(text, 1).ports, many = scene.play(text, 256).ports;
  CHECK(one[0].given == many[0].given);
  CHECK(one[0].net == many[0].net);
}

TEST_CASE("energy_watch: a scene may expect it, of the whole or of a part", "[scene]") {
  const SpringScene scene;
  const auto text = scene.text("20 ms", kArm, R"(all = { measure = "energy_given", of = "arm", max = "1 mJ" }
start = { measure = "energy_given", of = "arm", to = "0.05 s", max = "1 mJ" })");
  const auto recording = scene.play(text);
  const auto outcomes = check_expectations(
      *test::parse_scene(text, (scene.path() / "scene.toml").generic_string(), scene.path()), recording);
  REQUIRE(outcomes);
  CHECK((*outcomes)[0].value == recording.ports[0].given);
  CHECK((*outcomes)[0].unit == "J");
  CHECK_FALSE((*outcomes)[0].holds);
  CHECK((*outcomes)[1].holds);
}

TEST_CASE("energy_watch: errors of a port are reported before anything plays", "[scene]") {
  const SpringScene scene;
  const auto errors_of = [&](const std::string& ports, const std::string& expect = "") {
    const auto built = scene.build(scene.text("0 ms", ports, expect));
    return scene.strip(test::summary(built));
  };
  CHECK(errors_of(kArm) == "");
  CHECK(errors_of(R"(a = { force = "plant.forse", position = "plant.arm", active_up_to = "1 mJ" })") ==
        "scene.toml:12:15 UnknownName 'plant.forse' 'plant.force'");
  CHECK(errors_of(R"(a = { force = "plant.force", position = "plant.speed", active_up_to = "1 mJ" })") ==
        "scene.toml:12:1 UnitMismatch 'plant.force' 'plant.speed'");
  CHECK(errors_of(R"(a = { force = "plant.force", position = "plant.arm" })") ==
        "scene.toml:12:1 Missing 'a' 'active_up_to' 'active_up_to'");
  CHECK(errors_of(R"(a = { force = "plant.force", active_up_to = "1 N" })") ==
        R"(scene.toml:12:1 Missing 'a' 'position' 'position' "plant.arm"
scene.toml:12:45 UnitMismatch '1 N' 'active_up_to')");
  CHECK(errors_of(kArm, R"(e = { measure = "energy_given", of = "arn", max = 1 })") ==
        "scene.toml:14:38 UnknownName 'arn' 'arm'");
  CHECK(errors_of("", R"(e = { measure = "energy_given", of = "arm", max = 1 })") ==
        "scene.toml:14:38 UnknownName 'arm' [ports]");
}
