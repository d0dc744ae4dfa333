#include "engine/study/orbits/bifurcation.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "engine/nodes/table.h"
#include "engine/scene/measures/motion.h"
#include "engine/study/orbits/bouncing_ball.h"
#include "engine/study/sweep/scene_variants.h"
#include "tests/support/shipped_scene.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using test::play;

namespace {

SceneSpec scene_of(const char* file) {
  return test::shipped_scene(std::filesystem::path{"bouncing_ball"} / file);
}

std::vector<Landing> landings_of(const SceneRecording& recording) {
  return tactus::landings_of(recording.find("plant.ball")->samples, recording.find("plant.table")->samples,
                             recording.sample_rate);
}

/// Landings per cycle in the last three seconds of a scene.
int period_in(const char* file) {
  const auto recording = play(scene_of(file));
  return bouncing_in(recording.find("plant.ball")->samples, recording.find("plant.table")->samples,
                     recording.sample_rate, recording.seconds() - 3, recording.seconds())
      .period;
}

/// Where one landing a period doubles on the table, with a ball that touches it for so long: 48 frames. In
/// fewer, where in a frame it begins to moves the doubling; in 12 by up to 0.9 % of the ideal ball's.
double first_doubling(double touching_s) {
  auto scene = scene_of("table_scene.toml");
  scene.rate = Hertz{48 / touching_s};
  const double stiffness = 2.7e-3 * std::pow(std::numbers::pi / touching_s, 2);
  for (auto& part : scene.parts) part.wires.push_back({"stiffness", part.at, Value{stiffness, part.at}});
  BifurcationPlan plan;
  plan.control = "plant.gamma";
  plan.from = 1.49;
  plan.to = 1.56;
  plan.values = 15;
  plan.settling_s = 3;
  plan.restitution = 0.5;
  const auto study = study_bifurcation(scene, standard_nodes(), plan);
  if (!study) throw std::runtime_error(to_string(study.error()));
  return study->doublings.at(0).simulated.value();
}

}  // namespace

TEST_CASE("bifurcation: landings of a ball that falls and rebounds, on a table that moves", "[analysis]") {
  // From 50 mm, on a table that rises with 0.2 m/s from -20 mm; it leaves 0.8 times as fast as it came.
  const double g = 9.81, table_speed = 0.2, e = 0.8;
  const double t = (-table_speed + std::sqrt(table_speed * table_speed + 2 * g * 0.07)) / g;
  const double speed = g * t + table_speed, up = table_speed + e * speed;
  std::vector<double> ball, table;
  for (int n = 0; n < 9000; ++n) {
    const double s = n / 48000.0, after = s - t;
    table.push_back(-0.02 + table_speed * s);
    ball.push_back(s < t ? 0.05 - 0.5 * g * s * s
                         : -0.02 + table_speed * t + up * after - 0.5 * g * after * after);
  }
  // A touch has one sample on or below the table: it is put there.
  const auto first = static_cast<std::size_t>(std::ceil(t * 48000));
  ball[first] = table[first] - 1e-6;
  const auto landings = tactus::landings_of(ball, table, 48_kHz);
  REQUIRE(landings.size() == 1);
  CHECK(landings[0].time_s == Approx(t).epsilon(0).margin(1.0 / 48000));
  CHECK(landings[0].speed == Approx(speed).epsilon(0).margin(g / 48000));
  CHECK(landings[0].rebound == Approx(e * speed).epsilon(0).margin(2 * g / 48000));
}

TEST_CASE("bifurcation: how many landings until they repeat", "[analysis]") {
  std::vector<double> one(20, 1.0), three, never;
  for (int n = 0; n < 20; ++n) {
    three.push_back(1 + 0.1 * (n % 3));
    never.push_back(1 + 0.1 * std::sin(n * n));
  }
  CHECK(period_of(one) == 1);
  CHECK(period_of(three) == 3);
  CHECK(period_of(never) == 0);
  CHECK(period_of({}) == 0);
}

TEST_CASE("bifurcation: a doubling lies where the square of the split begins", "[analysis]") {
  std::vector<BifurcationColumn> columns;
  for (int i = 0; i < 10; ++i) {
    const double value = 1 + 0.1 * i, split = value > 1.43 ? std::sqrt(value - 1.43) : 0;
    BifurcationColumn column{value, {}, {}, split > 0 ? 2 : 1};
    for (int n = 0; n < 20; ++n) column.speeds.push_back(3 + (n % 2 == 0 ? split : -split));
    columns.push_back(column);
  }
  CHECK(doubling_in(columns, 1).value() == Approx(1.43).epsilon(1e-9));
  CHECK_FALSE(doubling_in(columns, 2));
}

TEST_CASE(
    "bifurcation: the simulated ball doubles where the ideal one does, the nearer the shorter it touches",
    "[analysis][slow]") {
  const double ideal = BouncingBall::orbit_doubles(1, 0.5);
  REQUIRE(ideal == Approx(1.526824).epsilon(1e-6));
  const double soft = std::abs(first_doubling(1e-3) - ideal),
               hard = std::abs(first_doubling(0.25e-3) - ideal);
  CHECK(soft < 0.03 * ideal);
  CHECK(hard < 0.005 * ideal);
  CHECK(hard < 0.5 * soft);
}

TEST_CASE("bifurcation: workers, parts and a cache change nothing", "[analysis]") {
  const test::TemporaryFolder folder;
  const auto scene = scene_of("table_scene.toml");
  BifurcationPlan plan;
  plan.from = 1.3;
  plan.to = 1.56;
  plan.values = 14;  // the last two columns are a run of their own, which plays three before them first
  plan.settling_s = 0.3;
  plan.reading_s = 0.5;
  plan.workers = 1;
  const auto whole = study_bifurcation(scene, standard_nodes(), plan);
  REQUIRE(whole);
  REQUIRE(whole->runs == 2);
  REQUIRE(whole->simulated.size() == 14);
  const auto same = [&](const BifurcationPlan& other) {
    const auto study = study_bifurcation(scene, standard_nodes(), other);
    return study && std::ranges::equal(study->simulated, whole->simulated, [](const auto& a, const auto& b) {
             return a.speeds == b.speeds && a.phases == b.phases && a.period == b.period;
           });
  };
  plan.workers = 2;
  CHECK(same(plan));
  plan.cache = folder.path();
  plan.parts = 2;
  const auto half = study_bifurcation(scene, standard_nodes(), plan);
  REQUIRE(half);
  CHECK(half->finished == 1);
  CHECK(half->simulated.empty());
  plan.part = 1;
  CHECK(same(plan));
  plan.stop = [] { return true; };  // all is there: nothing is begun
  CHECK(same(plan));
  for (const auto& column : whole->simulated) CHECK_FALSE(column.speeds.empty());
}

TEST_CASE("bifurcation: roles name the controls of the table, else those of their names do", "[analysis]") {
  BifurcationPlan plan;
  plan.from = 1.3;
  plan.to = 1.32;
  plan.values = 3;
  plan.settling_s = plan.reading_s = 0.1;
  auto scene = scene_of("table_scene.toml");
  const auto named = study_bifurcation(scene, standard_nodes(), plan);
  REQUIRE(named);
  CHECK(named->control == "plant.gamma");
  CHECK(named->frequency_hz == 29.93);
  for (auto& role : scene.control_roles) role.written = false;
  plan.control = "plant.gamma";
  CHECK(study_bifurcation(scene, standard_nodes(), plan)->frequency_hz == 29.93);
  for (auto& role : scene.control_roles) role = {role.name, "plant.drop_height", {}, true};
  CHECK(study_bifurcation(scene, standard_nodes(), plan)->frequency_hz == Approx(0.70727e-3));
}

TEST_CASE("bifurcation: controls that cannot be swept are errors", "[analysis]") {
  const auto error_of = [](SceneSpec scene, const std::string& control) {
    BifurcationPlan plan;
    plan.control = control;
    plan.from = 1;
    plan.to = 2;
    const auto study = study_bifurcation(scene, standard_nodes(), plan);
    return study ? Error{} : study.error().front();
  };
  const auto unknown = error_of(scene_of("scene.toml"), "gama");
  CHECK(unknown.code == Errc::UnknownName);
  CHECK(unknown.where == "gama");
  CHECK(unknown.remedy.find("'gamma'") != std::string::npos);
  CHECK(error_of(scene_of("table_scene.toml"), "gamma").code == Errc::UnknownName);
  auto scene = scene_of("scene.toml");
  scene.control_roles.clear();
  CHECK(error_of(scene, "").code == Errc::UnknownName);
  CHECK(error_of(scene, "plant.cone_mass").code == Errc::Missing);  // the frequency is not known
}

TEST_CASE("bouncing ball: on the woofer it lands once, twice, four times until it repeats, and never",
          "[instruments][slow]") {
  CHECK(period_in("scene.toml") == 1);
  CHECK(period_in("period_2.toml") == 2);
  CHECK(period_in("period_4.toml") == 4);
  CHECK(period_in("chaos.toml") == 0);
}

TEST_CASE("bouncing ball: around the chaotic drive there is no orbit within 1 %, at 48 kHz and at 96 kHz",
          "[instruments][slow]") {
  auto scene = scene_of("chaos.toml");
  scene.rate = GENERATE(48_kHz, 96_kHz);
  BifurcationPlan plan;
  plan.control = "gamma";
  plan.from = 0.99 * 1.8;
  plan.to = 1.01 * 1.8;
  plan.values = 5;
  plan.settling_s = 3;
  plan.reading_s = 3;
  const auto study = study_bifurcation(scene, standard_nodes(), plan);
  REQUIRE(study);
  for (const auto& column : study->simulated) {
    CHECK(column.speeds.size() > 50);
    CHECK(column.period == 0);
  }
}

TEST_CASE("bouncing ball: a billionth more drive moves an orbit by next to nothing, and chaos to elsewhere",
          "[instruments][slow]") {
  // An orbit of four landings may begin with any of them.
  const auto apart_at_end = [](const char* file) {
    constexpr std::size_t kSecond = 48000, kPeriod = 1600;
    const auto one = play(scene_of(file)),
               other = play(with_gesture_scaled(scene_of(file), "drive", 1 + 1e-9));
    const auto &a = one.find("plant.ball")->samples, &b = other.find("plant.ball")->samples;
    double least = 1;
    for (std::size_t shift = 0; shift < 4 * kPeriod; shift += kPeriod) {
      double most = 0;
      for (auto n = a.size() - kSecond; n < a.size(); ++n)
        most = std::max(most, std::abs(a[n] - b[n - shift]));
      least = std::min(least, most);
    }
    return least;
  };
  CHECK(apart_at_end("period_4.toml") < 1e-6);
  CHECK(apart_at_end("chaos.toml") > 0.5e-3);  // of jumps of some millimetres
}

TEST_CASE("bouncing ball: the lens moves as its input demands, and gives way to the ball as its mass says",
          "[instruments]") {
  const auto recording = play(scene_of("scene.toml"));
  const auto landings = landings_of(recording);
  REQUIRE(landings.size() > 100);
  // The ball leaves with (e M - m) / (M + m) of its speed: e = 0.9, M = 35 g, m = 2.7 g.
  CHECK(landings.back().rebound / landings.back().speed ==
        Approx((0.9 * 35 - 2.7) / 37.7).epsilon(0).margin(0.015));
  SceneOptions away;
  away.set = {{"plant.drop_height", 0.49}};
  auto brief = scene_of("scene.toml");
  brief.duration = Seconds{0.3};  // the ball falls all the while
  const auto table = play(brief, away).find("plant.table")->samples;
  const double w = 2 * std::numbers::pi * 30;
  for (std::size_t n = 9600; n < table.size(); n += 7)
    CHECK(
        table[n] ==
        Approx(0.9 * 9.81 / (w * w) * std::sin(w * static_cast<double>(n) / 48000)).epsilon(0).margin(3e-6));
}

TEST_CASE("bouncing ball: at rest it stays down below the acceleration of gravity and leaves above it",
          "[instruments]") {
  const auto flies = [](double gamma) {
    SceneOptions options;
    options.set = {{"plant.gamma", gamma}, {"plant.drop_height", 0.0}, {"plant.thrown", 0.0}};
    auto scene = scene_of("table_scene.toml");
    scene.duration = 1_s;
    const auto recording = play(scene, options);
    const auto& ball = recording.find("plant.ball")->samples;
    const auto& table = recording.find("plant.table")->samples;
    double most = 0;
    for (std::size_t n = 24000; n < ball.size(); ++n) most = std::max(most, ball[n] - table[n]);
    return most;
  };
  // The ball starts on a table that moves up at once; what that leaves has died away after half a second.
  CHECK(flies(0.99) <= 0);
  CHECK(flies(1.01) > 0);
}
