#include <Eigen/Eigenvalues>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "engine/nodes/networks/network.h"
#include "engine/physics/linearised.h"
#include "engine/runtime/player.h"
#include "tests/support/error_summary.h"
#include "tests/support/graphs/graph_runner.h"

using namespace tactus;
using namespace tactus::test;

namespace {

std::string space_graph(const std::string& elements, const std::string& out = "n.energy / 1 J") {
  return "format = 1\nname = \"n\"\n[networks.n]\n" + elements + "\n[outputs]\nout = { from = \"" + out +
         "\" }\n";
}

/// Frequencies of all modes of the small-signal network [Hz], rising.
std::vector<double> frequencies_of(const std::string& elements) {
  const auto player = engine_of(space_graph(elements));
  for (const auto& node : player->plan().nodes) {
    const auto* view = dynamic_cast<const NetworkView*>(node.get());
    if (view == nullptr) continue;
    const NetworkModel model(tangent(view->recipe.elements, {}), 0, 1.0 / 48e3);
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(model.masses, model.masses);
    for (const auto& e : model.links().entries)
      if (e.column < model.masses)
        matrix(e.row, e.column) += e.k / std::sqrt(model.mass[index(e.row)] * model.mass[index(e.column)]);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solved(matrix, Eigen::EigenvaluesOnly);
    std::vector<double> all;
    for (const double square : solved.eigenvalues())
      all.push_back(std::sqrt(std::max(0.0, square)) / (2.0 * std::numbers::pi));
    return all;
  }
  throw std::runtime_error("no network");
}

/// 4 sin^2(p pi / 2 (n + 1)): minus the second difference of the p-th mode of n masses between fixed ends.
double bend(int p, int n) { return 4.0 * std::pow(std::sin(p * std::numbers::pi / (2.0 * (n + 1))), 2); }

std::string errors_in(const std::string& elements) { return errors_of(space_graph(elements)); }

}  // namespace

TEST_CASE("plates: a membrane has the modes of its grid, and those of theory but for the dispersion",
          "[physics]") {
  // a = 6 h, b = 9 h: f = (c / 2) sqrt((m/a)^2 + (n/b)^2), c = h sqrt(k / m); lower by (p pi / N)^2 / 24.
  const auto f = frequencies_of(
      "skin = { type = \"grid\", rows = 5, columns = 8, mass = \"1 g\", stiffness = \"10 kN/m\" }");
  const double w = std::sqrt(10e3 / 1e-3) / (2.0 * std::numbers::pi);
  CHECK(f[0] == Approx(w * std::sqrt(bend(1, 5) + bend(1, 8))));
  CHECK(f[1] == Approx(w * std::sqrt(bend(1, 5) + bend(2, 8))));
  const double theory = 0.5 * std::sqrt(1e7) * std::hypot(1.0 / 6.0, 1.0 / 9.0);
  CHECK(f[0] < theory);
  CHECK(f[0] > theory * (1.0 - std::pow(std::numbers::pi / 6.0, 2) / 24.0));
}

TEST_CASE("plates: a simply supported plate has the modes of Leissa but for the dispersion", "[physics]") {
  // f = (pi / 2) sqrt(D / (rho h)) ((m/a)^2 + (n/b)^2) with sqrt(D / (rho h)) = h^2 sqrt(B / m), lower by
  // (p pi / N)^2 / 12.
  const auto f = frequencies_of(
      "plate = { type = \"grid\", rows = 5, columns = 8, mass = \"1 g\", stiffness = \"0 N/m\", "
      "bending_stiffness = \"10 kN/m\" }");
  const double w = std::sqrt(10e3 / 1e-3) / (2.0 * std::numbers::pi);
  CHECK(f[0] == Approx(w * (bend(1, 5) + bend(1, 8))));
  CHECK(f[1] == Approx(w * (bend(1, 5) + bend(2, 8))));
  CHECK(f.back() == Approx(w * (bend(5, 5) + bend(8, 8))));
  const double theory = 0.5 * std::numbers::pi * std::sqrt(1e7) * (1.0 / 36.0 + 1.0 / 81.0);
  CHECK(f[0] < theory);
  CHECK(f[0] > theory * (1.0 - std::pow(std::numbers::pi / 6.0, 2) / 12.0));
}

TEST_CASE("plates: bars that are free, clamped and supported", "[physics]") {
  // w = (beta / L)^2 sqrt(EI / mu) = beta^2 / N^2 sqrt(B / m), L = N h: free ends lie half a distance beyond
  // the last mass, the others a whole one. The finite differences are off by some 1 / N^2.
  struct Case {
    const char* ends;
    double beta, lengths;
    int rigid;
  };
  const auto bar = GENERATE(Case{"free", 4.730041, 60.0, 2}, Case{"clamped", 4.730041, 61.0, 0},
                            Case{"fixed", std::numbers::pi, 61.0, 0});
  const auto f =
      frequencies_of(std::string("bar = { type = \"chain\", masses = 60, mass = \"1 g\", stiffness "
                                 "= \"0 N/m\", bending_stiffness = \"10 kN/m\", ends = \"") +
                     bar.ends + "\" }");
  const double w = std::sqrt(10e3 / 1e-3) / (2.0 * std::numbers::pi);
  // Twice 1e-16 of the highest, whose square is 16 B / m.
  for (int i = 0; i < bar.rigid; ++i) CHECK(f[index(i)] < 1e-6 * f.back());
  CHECK(f[index(bar.rigid)] == Approx(w * std::pow(bar.beta / bar.lengths, 2)).epsilon(3e-3));
}

TEST_CASE("plates: a closed ring of bending stiffness has no resonance but its own", "[physics]") {
  // Bending alone: w = 4 sin^2(pi p / N) sqrt(B / m), each twice, and one for p = 0.
  const auto f = frequencies_of(
      "hoop = { type = \"ring\", masses = 12, mass = \"1 g\", stiffness = \"0 N/m\", bending_stiffness = "
      "\"10 "
      "kN/m\" }");
  const double w = std::sqrt(10e3 / 1e-3) / (2.0 * std::numbers::pi);
  CHECK(f[0] < 1e-6 * f.back());
  for (const int p : {1, 2, 3})
    for (const int twin : {2 * p - 1, 2 * p})
      CHECK(f[index(twin)] == Approx(w * 4.0 * std::pow(std::sin(std::numbers::pi * p / 12.0), 2)));
}

TEST_CASE("plates: a free square plate moves as a body, twists and bends", "[physics]") {
  // w a^2 sqrt(rho h / D) = 13.49, 19.79, 24.43 for nu = 0.3 (Leissa, Vibration of Plates, NASA SP-160, 1969,
  // table 4.67); the border is of first order in the distance of the masses, 1 / 16 of the side.
  const auto f = frequencies_of(
      "plate = { type = \"grid\", rows = 16, columns = 16, mass = \"1 g\", stiffness = \"0 N/m\", "
      "bending_stiffness = \"10 kN/m\", ends = \"free\", poisson_ratio = 0.3 }");
  const double w = std::sqrt(10e3 / 1e-3) / (2.0 * std::numbers::pi) / (16.0 * 16.0);
  for (const int rigid : {0, 1, 2}) CHECK(f[index(rigid)] < 1e-6 * f.back());
  CHECK(f[3] == Approx(13.49 * w).epsilon(0.05));
  CHECK(f[4] == Approx(19.79 * w).epsilon(0.03));
  CHECK(f[5] == Approx(24.43 * w).epsilon(0.03));
}

TEST_CASE("plates: a struck plate keeps its energy with every solver", "[physics]") {
  const auto solver = GENERATE("passive", "implicit", "exact", "explicit", "auto");
  const auto player = engine_of(space_graph(
      std::string("solver = \"") + solver +
          "\"\nplate = { type = \"grid\", rows = 6, columns = 7, mass = \"1 g\", stiffness = \"0 N/m\", "
          "bending_stiffness = \"20 kN/m\" }\nstick = { type = \"mass\", mass = \"5 g\", at = \"1 mm\", "
          "velocity = \"-1 m/s\" }\ntip = { type = \"contact\", between = [\"plate.3.3\", \"stick\"], "
          "stiffness = \"1e6 N/m^1.5\" }",
      "n.energy / 1 mJ"));
  const auto energy = run(*player, {}, 48000, {64})[0];
  // What explicit steps show of springs and of the contact is off by some (w k)^2 / 4 of it.
  const bool kept = std::string(solver) != "explicit" && std::string(solver) != "auto";
  const auto [least, most] = std::minmax_element(energy.begin(), energy.end());
  CHECK(*most - *least < (kept ? 1e-9 : 0.1) * 2.5);
  CHECK(energy[0] == Approx(2.5));
}

TEST_CASE("space elements: a thread and a sheet at rest are a string and a membrane", "[physics]") {
  // Across the thread T / spacing is its stiffness, w^2 = (T / (m h)) bend; along it `stiffness`. A sheet has
  // both for each of its directions.
  const auto geometry = GENERATE("linear", "nonlinear");
  const auto thread = frequencies_of(
      std::string(
          "s = { type = \"thread\", masses = 7, mass = \"1 g\", stiffness = \"50 kN/m\", spacing = \"10 "
          "mm\", tension = \"20 N\", geometry = \"") +
      geometry + "\" }");
  const double across = std::sqrt(20.0 / 0.01 / 1e-3) / (2.0 * std::numbers::pi);
  REQUIRE(thread.size() == 21);
  for (const int twin : {0, 1}) CHECK(thread[index(twin)] == Approx(across * std::sqrt(bend(1, 7))));
  CHECK(thread.back() == Approx(std::sqrt(50e3 / 1e-3 * bend(7, 7)) / (2.0 * std::numbers::pi)));
  const auto sheet = frequencies_of(
      std::string("s = { type = \"sheet\", rows = 3, columns = 4, mass = \"1 g\", stiffness = \"50 kN/m\", "
                  "spacing = \"10 mm\", tension = \"20 N\", geometry = \"") +
      geometry + "\" }");
  CHECK(sheet.front() == Approx(across * std::sqrt(bend(1, 3) + bend(1, 4))));
}

TEST_CASE("space elements: every element of one axis acts on an axis by its name", "[physics]") {
  // Falls onto a floor in y while it flies on in x at 1 m/s, without friction.
  const auto player = engine_of(space_graph(
      "solver = \"passive\"\nball = { type = \"particle\", axes = 2, mass = \"10 g\", y = \"20 mm\", "
      "velocity_x = \"1 "
      "m/s\" }\nfloor = { type = \"ground\" }\nhit = { type = \"contact\", between = [\"floor\", "
      "\"ball.y\"], "
      "stiffness = \"1e6 N/m^1.5\" }\nweight = { type = \"force\", on = \"ball.y\", force = \"-0.0981 N\" }",
      "n.ball.y / 1 m"));
  const auto y = run(*player, {}, 48000, {64})[0];
  CHECK(*std::min_element(y.begin(), y.end()) > -1e-3);
  CHECK(*std::max_element(y.begin() + 24000, y.end()) == Approx(0.02).epsilon(0.01));
}

TEST_CASE("space elements: outputs have a name for each axis", "[physics]") {
  const auto at = [](const std::string& axis) {
    return run(
        *engine_of(space_graph("bob = { type = \"particle\", mass = \"1 g\", x = \"1 m\", y = \"2 m\", z = "
                               "\"3 m\", velocity_z = \"48 m/s\" }",
                               "n.bob." + axis)),
        {}, 2, {64})[0][1];
  };
  CHECK(at("x / 1 m") == 1.0);
  CHECK(at("y / 1 m") == 2.0);
  CHECK(at("z / 1 m") == Approx(3.001));
  CHECK(at("velocity_z / 1 m/s") == Approx(48.0));
}

TEST_CASE("space elements: a line to a trajectory follows it", "[physics]") {
  // Static: a light body on a spring of rest 0 to a fixed path comes to rest there.
  const auto player = engine_of(space_graph(
      "finger = { type = \"trajectory\", axes = 2, x = \"3 mm\", y = \"-4 mm\" }\nbob = { type = "
      "\"particle\", "
      "axes = "
      "2, mass = \"1 g\" }\ncord = { type = \"line_spring\", between = [\"finger\", \"bob\"], stiffness = "
      "\"100 "
      "N/m\", rest = \"0 m\" }\nair = { type = \"damper\", between = [\"floor\", \"bob.x\"], damping = \"0.5 "
      "N "
      "s/m\" }\nair_y = { type = \"damper\", between = [\"floor\", \"bob.y\"], damping = \"0.5 N s/m\" "
      "}\nfloor = { type = \"ground\" }",
      "n.bob.y / 1 mm"));
  CHECK(run(*player, {}, 48000, {64})[0].back() == Approx(-4.0).epsilon(1e-6));
}

TEST_CASE("space elements: errors name the axis, the body and the remedy", "[physics]") {
  const std::string bob = "bob = { type = \"particle\", mass = \"1 g\" }\n";
  const std::string floor = "floor = { type = \"ground\" }\n", end = ", stiffness = \"1 N/m\" }";
  CHECK(errors_in(bob + floor + R"(s = { type = "spring", between = ["floor", "bob"])" + end) ==
        R"(test.toml:6:44 WrongType 'bob' "bob.x")");
  CHECK(errors_in(bob + floor + R"(s = { type = "line_spring", between = ["floor", "bob"])" + end) ==
        "test.toml:6:40 WrongType 'floor'");
  CHECK(errors_in(bob + "hook = { type = \"anchor\", axes = 2 }\n" +
                  R"(s = { type = "line_spring", between = ["hook", "bob"])" + end) ==
        "test.toml:6:39 WrongType 'hook' 2 'bob' 3 'axes'");
  CHECK(errors_in(bob + "hook = { type = \"anchor\" }\n" +
                  R"(s = { type = "line_spring", between = ["hook.x", "bob"])" + end) ==
        R"(test.toml:6:40 WrongType 'hook.x' "hook")");
  // What was written without a type is an error once.
  CHECK(errors_in(bob + "floor = { mass = \"1 g\" }\n" +
                  R"(s = { type = "line_spring", between = ["floor", "bob"])" + end) ==
        R"(test.toml:5:1 Missing 'floor' 'n' 'type' type "mass")");
  CHECK(errors_in(R"(bob = { type = "particle", axes = 2, mass = "1 g", z = "1 m" })") ==
        "test.toml:4:56 UnknownName 'bob' 2 'z' axes 3");
  CHECK(errors_in("bob = { type = \"particle\", axes = 2, mass = \"1 g\" }\n" +
                  std::string(R"(w = { type = "force", on = "bob.z", force = "1 N" })")) ==
        R"(test.toml:5:28 WrongType 'bob' "bob.x")");
  CHECK(errors_in("motion = \"rotation\"\n" + bob) == R"(test.toml:5:16 WrongType 'bob' motion "rotation")");
  CHECK(errors_in(bob + "finger = { type = \"trajectory\", x = \"1 mm\" }\n" +
                  R"(s = { type = "line_spring", between = ["finger", "bob"])" + end) ==
        R"(test.toml:6:1 Missing 's' 'rest' geometry "nonlinear")");
}
