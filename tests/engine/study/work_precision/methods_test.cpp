#include "engine/study/work_precision/methods/methods.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "engine/nodes/table.h"
#include "engine/physics/network.h"
#include "engine/study/work_precision/work_precision.h"

using namespace tactus;

namespace {

constexpr Hertz kRate = 48_kHz;

/// The mass of 10 g is 1 mm above.
NetworkElements ground_and_mass(double velocity) {
  NetworkElements elements;
  elements.points.resize(2);
  elements.points[0].kind = Point::Kind::Ground;
  elements.points[1].mass = 0.01;
  elements.points[1].position = 1e-3;
  elements.points[1].velocity = velocity;
  return elements;
}

NetworkElements oscillator(double stiffness) {
  auto elements = ground_and_mass(0.0);
  auto& spring = elements.springs.emplace_back();
  spring.upper = 1;
  spring.stiffness = stiffness;
  return elements;
}

Network network_of(const NetworkElements& elements, const std::string& method, int oversample = 1) {
  return Network::make(elements, 0, kRate, oversample, find_method(method)->make);
}

/// Of an oscillator of w k = `step`: by its phase after some hundred turns.
double frequency_error(const std::string& method, double step) {
  constexpr int kFrames = 4000;
  constexpr double kTurn = 2 * std::numbers::pi;
  const double w = step * kRate.value;
  const auto network = network_of(oscillator(0.01 * w * w), method);
  auto state = network.initial_state();
  double angle = 0, turns = 0;
  for (int n = 0; n < kFrames; ++n) {
    network.step(state, nullptr);
    const double before = angle;
    angle = std::atan2(-network.velocity(state, 1) / w, network.position(state, 1));
    if (angle < before - 3.0) ++turns;
  }
  return (angle + kTurn * turns) / (step * kFrames) - 1;
}

/// A ball of 10 g that flies at 1 m/s towards a wall of K n^1.5, 1 mm away.
NetworkElements ball(double stiffness) {
  auto elements = ground_and_mass(-1.0);
  auto& contact = elements.contacts.emplace_back();
  contact.upper = 1;
  contact.stiffness = stiffness;
  return elements;
}

/// How fast it leaves.
double rebound(const std::string& method, double stiffness, int oversample) {
  const auto network = network_of(ball(stiffness), method, oversample);
  auto state = network.initial_state();
  double before = 0, now = 0;
  for (int n = 0; n < 400; ++n) {
    before = now;
    network.step(state, nullptr);
    now = network.position(state, 1);
  }
  return (now - before) * kRate.value;
}

}  // namespace

TEST_CASE("published methods: their frequencies are wrong as theory says", "[analysis]") {
  const double step = 0.2;
  // Störmer: 2 asin(x/2); SAV is the same without contacts. Newmark: 2 atan(x/2). Gauss-Legendre: the (2,2)
  // Padé approximant, whose phase is 2 atan(x/2 / (1 - x^2/12)).
  const double stormer = 2 * std::asin(step / 2) / step - 1;
  CHECK(frequency_error("verlet", step) == Approx(stormer).epsilon(0.02));
  CHECK(frequency_error("sav", step) == Approx(stormer).epsilon(0.02));
  CHECK(frequency_error("newmark", step) == Approx(2 * std::atan(step / 2) / step - 1).epsilon(0.02));
  CHECK(frequency_error("gauss", step) ==
        Approx(2 * std::atan(step / 2 / (1 - step * step / 12)) / step - 1).epsilon(0.05));
}

TEST_CASE("published methods: the scalar auxiliary variable keeps the energy in a contact of any length",
          "[analysis]") {
  // A touch lasts 95, 15 and 2.4 frames: 3.218 (m^2 / K^2 v)^(1/5).
  for (const double stiffness : {1e6, 1e8, 1e10}) {
    CAPTURE(stiffness);
    const auto network = network_of(ball(stiffness), "sav");
    auto state = network.initial_state();
    double most = 0;
    for (int n = 0; n < 400; ++n) {
      network.step(state, nullptr);
      most = std::max(most, std::abs(network.energy(state) / 5e-3 - 1));
    }
    CHECK(most < 1e-9);
  }
}

TEST_CASE("published methods: each converges to the rebound of a lossless contact", "[analysis]") {
  for (const auto& method : published_methods()) {
    CAPTURE(method.name);
    CHECK(rebound(method.name, 1e7, 16) == Approx(1.0).epsilon(1e-4));
  }
}

TEST_CASE("published methods: with a coil they converge to the linear motion in their order", "[analysis]") {
  const std::filesystem::path root = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments";
  const auto scene = load_scene(root / "numerics/woofer", root).value();
  const auto study = study_work_precision(scene, standard_nodes(),
                                          {{}, {"verlet", "newmark", "sav", "gauss"}, {24_kHz}, {1, 2}, 0});
  REQUIRE(study);
  for (std::size_t i = 0; i < study->points.size(); i += 2) {
    const auto &coarse = study->points[i], &fine = study->points[i + 1];
    CAPTURE(coarse.variant.solver);
    REQUIRE(coarse.known());
    const double least = coarse.variant.solver == "gauss" ? 14.0 : 3.0;
    for (std::size_t a = 0; a < coarse.errors.size(); ++a) CHECK(coarse.errors[a] > least * fine.errors[a]);
  }
}

TEST_CASE("published methods: none applies to friction, and the study says so", "[analysis]") {
  const std::filesystem::path root = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments";
  const auto scene = load_scene(root / "numerics/friction_drive", root).value();
  const auto study = study_work_precision(scene, standard_nodes(), {{}, {"gauss"}, {48_kHz}, {1}, 0});
  REQUIRE(study);
  REQUIRE(study->points[0].refused);
  CHECK(study->points[0].refused->what.starts_with("not applicable: friction"));
}
