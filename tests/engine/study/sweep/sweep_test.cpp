#include "engine/study/sweep/sweep.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/nodes/table.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/well_formed.h"

using namespace tactus;

namespace {

/// A sine through a low-pass at 1 kHz, and the same sine on a mass (10 g) on a spring (1000 N/m) with a
/// damper (1 N s/m).
class Bench {
 public:
  Bench() {
    folder_.write("plant.toml", R"(format = 1
[controls]
frequency = { value = "50 Hz", range = ["1 Hz", "20 kHz"] }
[networks.n]
frame  = { type = "ground" }
body   = { type = "mass", mass = "10 g" }
spring = { type = "spring", between = ["frame", "body"], stiffness = "1000 N/m", damping = "1 N s/m" }
push   = { type = "force", on = "body", force = "1 N * tone" }
[nodes]
tone = { type = "sine", frequency = "frequency" }
low  = { type = "low_pass", in = "tone", cutoff = "1 kHz" }
[outputs]
x = { from = "n.body.position", unit = "m" }
y = { from = "low" }
)");
    folder_.write("scene.toml", R"(format = 1
name = "bench"
duration = "0.4 s"
[parts]
plant = { use = "plant.toml" }
[gestures]
effort = { points = [["0 s", 1]] }
[expect]
deep = { measure = "rms", of = "plant.x", from = "0.2 s", to = "0.4 s", min = "1 mm" }
)");
    scene = *load_scene(folder_.path());
  }

  SweepTable sweep(const std::vector<SweptValue>& over, const std::string& measure) {
    SweepPlan plan;
    plan.over = over;
    auto what = *find_swept_measure(scene, measure);
    what.from_s = 0.2;
    what.to_s = 0.4;
    auto table = sweep_measures(scene, standard_nodes(), plan, {what});
    if (!table) throw std::runtime_error(to_string(table.error()));
    return *table;
  }
  SweptValue over(const std::string& name, const std::vector<double>& values) const {
    auto swept = find_swept(scene, name, {values.begin(), values.end()});
    if (!swept) throw std::runtime_error(to_string(swept.error()));
    return *swept;
  }

  SceneSpec scene;

 private:
  test::TemporaryFolder folder_;
};

double result(const SweepTable& table, std::size_t point) { return table.points[point].result->front(); }

/// Root mean square of the position of the mass.
double driven_rms(double hertz, double mass) {
  const double w = 2 * std::numbers::pi * hertz;
  return std::numbers::sqrt2 / 2 / std::hypot(1000 - mass * w * w, w);
}

}  // namespace

TEST_CASE("sweep: the gain of a low-pass over frequency is 0 dB, and -3.01 dB at its cutoff", "[sweep]") {
  Bench bench;
  const auto table = bench.sweep({bench.over("plant.frequency", {10, 1000})}, "rms:plant.y");
  const auto gain_db = [&](std::size_t point) {
    return 20 * std::log10(result(table, point) * std::numbers::sqrt2);
  };
  CHECK(gain_db(0) == Approx(0).margin(0.01));
  CHECK(gain_db(1) == Approx(-3.0103).margin(0.01));
}

TEST_CASE("sweep: a driven mass on a spring follows its transfer function", "[sweep]") {
  Bench bench;
  const std::vector<double> frequencies{20, 45, 50, 100}, masses{0.005, 0.02};
  const auto table = bench.sweep(
      {bench.over("plant.frequency", frequencies), bench.over("plant.n.body.mass", masses)}, "rms:plant.x");
  REQUIRE(table.points.size() == 8);
  for (const auto& point : table.points)
    CHECK(point.result->front() == Approx(driven_rms(point.at[0], point.at[1])).epsilon(5e-3));
}

TEST_CASE("sweep: solver, oversampling and rate leave a resolved motion alone", "[sweep]") {
  Bench bench;
  for (const auto& swept :
       {*swept_solvers({"explicit", "exact", "passive"}), bench.over("oversample", {1, 4}),
        bench.over("rate", {24e3, 48e3, 96e3}), bench.over("delay", {0, 0.01})}) {
    const auto table = bench.sweep({swept}, "rms:plant.x");
    for (std::size_t i = 0; i < table.points.size(); ++i)
      CHECK(result(table, i) == Approx(driven_rms(50, 0.01)).epsilon(2e-2));
  }
}

TEST_CASE("sweep: draws stay within their range of the plant", "[sweep]") {
  Bench bench;
  SweepPlan plan;
  plan.draws = 8;
  plan.within = 0.01;
  auto measure = *find_swept_measure(bench.scene, "deep");
  const auto table = sweep_measures(bench.scene, standard_nodes(), plan, {measure});
  REQUIRE(table);
  REQUIRE(table->points.size() == 9);
  CHECK(table->points[8].variant == "draw 8");
  for (const auto& point : table->points)
    // At resonance the damper decides: 1 % of it, and the detuning by 1 % of mass and spring.
    CHECK(point.result->front() == Approx(driven_rms(50, 0.01)).epsilon(0.05));
  CHECK(table->points[1].result != table->points[2].result);
}

TEST_CASE("sweep: names that are not there are errors with the nearest name", "[sweep]") {
  Bench bench;
  const auto refused = [&](const std::string& name, const std::string& near) {
    const auto swept = find_swept(bench.scene, name, {1.0});
    REQUIRE_FALSE(swept);
    CHECK(swept.error().code == Errc::UnknownName);
    CHECK(swept.error().where == "--over");
    CHECK(swept.error().remedy.find("'" + near + "'") != std::string::npos);
    for (const auto* known : {"plant.frequency", "effort", "plant.n.spring.stiffness", "plant.low.cutoff"})
      CHECK(swept.error().remedy.find(known) != std::string::npos);
  };
  refused("plant.frequenzy", "plant.frequency");
  refused("efort", "effort");
  refused("plant.n.body.mas", "plant.n.body.mass");
  refused("dely", "delay");
  CHECK(swept_solvers({"euler"}).error().code == Errc::UnknownName);
  CHECK(find_swept(bench.scene, "delay", {2.0}).error().code == Errc::OutOfRange);
  CHECK(find_swept_measure(bench.scene, "rmss:plant.x").error().remedy.find("'rms'") != std::string::npos);
}

TEST_CASE("sweep: a constant is changed in one use of a part only", "[sweep]") {
  const test::TemporaryFolder folder;
  folder.write(
      "tone.toml",
      "format = 1\n[nodes]\ntone = { type = \"sine\", frequency = \"100 Hz\", level = 0.5 }\n[outputs]\n"
      "y = { from = \"tone\" }\n");
  folder.write("plant.toml",
               "format = 1\n[nodes]\na = { use = \"tone.toml\" }\nb = { use = \"tone.toml\" }\n[outputs]\n"
               "a = { from = \"a\" }\nb = { from = \"b\" }\n");
  folder.write("scene.toml", "format = 1\nduration = \"0.1 s\"\n[parts]\nplant = { use = \"plant.toml\" }\n");
  const auto scene = load_scene(folder.path());
  REQUIRE(scene);
  SweepPlan plan;
  plan.over = {*find_swept(*scene, "plant.b.tone.level", {0.5, 1.0})};
  const auto table = sweep_measures(
      *scene, standard_nodes(), plan,
      {*find_swept_measure(*scene, "peak:plant.a"), *find_swept_measure(*scene, "peak:plant.b")});
  REQUIRE(table);
  CHECK((*table->points[1].result)[0] == Approx(0.5).epsilon(1e-3));
  CHECK((*table->points[1].result)[1] == Approx(1.0).epsilon(1e-3));
}

TEST_CASE("sweep: one quantity is drawn as a line, two as a map, draws as points", "[sweep]") {
  Bench bench;
  const auto frequency = bench.over("plant.frequency", {20, 50, 100}),
             mass = bench.over("plant.n.body.mass", {0.01, 0.02});
  const auto line = plots_of(bench.sweep({frequency}, "rms:plant.x"));
  REQUIRE(line.size() == 1);
  CHECK(line[0].subplots[0].series[0].y.size() == 3);
  const auto map = plots_of(bench.sweep({frequency, mass}, "rms:plant.x"));
  REQUIRE(map.size() == 1);
  CHECK(map[0].subplots[0].map->cells.size() == 6);
  CHECK(test::well_formed(to_svg(map)));
  CHECK(plots_of(bench.sweep({frequency, mass, bench.over("rate", {24e3, 48e3})}, "rms:plant.x")).size() ==
        2);
}
