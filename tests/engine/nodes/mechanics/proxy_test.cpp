#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/graphs/play_node.h"

// Contact by a proxy: forces of springs, cones of friction, and sides that a device does not get through.

using namespace tactus;
using test::refusal;
using test::Samples;

namespace {

constexpr double kStiffness = 1000;
using Way = std::vector<std::array<double, 3>>;

struct Contact {
  std::map<std::string, test::InputValue> inputs = {};
  std::map<std::string, std::string> settings = {};

  /// All outputs along a way of the device, by name.
  std::map<std::string, Samples> along(const Way& way) const {
    const auto& type = test::node_type("proxy");
    auto given = inputs;
    given.emplace("stiffness", kStiffness);
    const char* const kAxes[] = {"x", "y", "z"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Samples places;
      for (const auto& place : way) places.push_back(place[axis]);
      given[kAxes[axis]] = places;
    }
    test::NodeRunner runner(type, given, settings);
    const auto outputs = runner.run(test::even_cutting(static_cast<int>(way.size()), test::kLongestSubBlock));
    std::map<std::string, Samples> named;
    for (std::size_t o = 0; o < outputs.size(); ++o) named[type.outputs[o].name] = outputs[o];
    return named;
  }
};

Contact solid(const std::string& shape, std::map<std::string, test::InputValue> inputs = {}) {
  return {std::move(inputs), {{"shape", shape}}};
}

/// A straight way, both ends included.
void lead(Way& way, const std::array<double, 3>& to, int steps) {
  const auto from = way.back();
  for (int n = 1; n <= steps; ++n) {
    std::array<double, 3> place{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      place[axis] = from[axis] + (to[axis] - from[axis]) * n / steps;
    way.push_back(place);
  }
}

/// Work on the device: its force at each place, by the trapezoidal rule.
double work(const std::map<std::string, Samples>& felt, const Way& way) {
  double sum = 0;
  const char* const kForces[] = {"force_x", "force_y", "force_z"};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t n = 1; n < way.size(); ++n)
      sum += 0.5 * (felt.at(kForces[axis])[n] + felt.at(kForces[axis])[n - 1]) *
             (way[n][axis] - way[n - 1][axis]);
  return sum;
}

}  // namespace

TEST_CASE("proxy: without friction each solid pushes as a spring across its surface", "[nodes]") {
  SECTION("an oblique plane") {
    Way way{{0.01, 0, 0.02}};
    lead(way, {0.006, 0.003, -0.002}, 50);
    const auto felt = solid("plane", {{"normal_x", 3.0}, {"normal_z", 4.0}, {"at_z", 0.001}}).along(way);
    const double depth = -(0.6 * 0.006 + 0.8 * (-0.002 - 0.001));
    REQUIRE(depth < 0);  // not yet in touch
    CHECK(felt.at("force_x").back() == 0);
    lead(way, {-0.004, 0.003, -0.002}, 50);
    const auto pressed = solid("plane", {{"normal_x", 3.0}, {"normal_z", 4.0}, {"at_z", 0.001}}).along(way);
    const double in = 0.6 * 0.004 + 0.8 * 0.003;
    CHECK(pressed.at("depth").back() == Approx(in).epsilon(1e-12));
    CHECK(pressed.at("force_x").back() == Approx(0.6 * kStiffness * in).epsilon(1e-12));
    CHECK(pressed.at("force_y").back() == Approx(0).margin(1e-12));
    CHECK(pressed.at("force_z").back() == Approx(0.8 * kStiffness * in).epsilon(1e-12));
    CHECK(pressed.at("touches").back() == 1);
  }
  SECTION("a sphere, around which the device moves") {
    Way way{{0.03, 0, 0}};
    lead(way, {0.018, 0, 0}, 20);
    for (int n = 1; n <= 4000; ++n)
      way.push_back({0.018 * std::cos(n * 1e-3), 0.018 * std::sin(n * 1e-3), 0});
    const auto felt = solid("sphere").along(way);
    // It is 2 mm deep; behind the device the proxy is (depth / radius)^4 of a step, 1e-7 rad.
    CHECK(felt.at("force_x").back() == Approx(2 * std::cos(4.0)).margin(1e-5));
    CHECK(felt.at("force_y").back() == Approx(2 * std::sin(4.0)).margin(1e-5));
    CHECK(felt.at("depth").back() == Approx(0.002).epsilon(1e-5));
  }
  SECTION("a box, two axes") {
    Way way{{0.03, 0.005, 0}};
    lead(way, {0.019, 0.005, 0}, 30);
    const auto felt = solid("box").along(way);
    CHECK(felt.at("force_x").back() == Approx(1).epsilon(1e-9));
    CHECK(felt.at("force_y").back() == Approx(0).margin(1e-12));
    CHECK(felt.at("force_z").back() == Approx(0).margin(1e-12));
  }
  SECTION("a slope of heights: 10 mm up in 20 mm") {
    Contact contact = solid("heights", {{"pitch", 0.02}});
    contact.settings["heights"] = "[0, 0.01, 0.02]";
    Way way{{0.005, 0, 0.03}};
    lead(way, {0.005, 0, 0.009}, 60);
    for (int n = 0; n < 40; ++n) way.push_back(way.back());
    const auto felt = contact.along(way);
    const double height = 0.01 + 0.5 * 0.005 - 0.009, cosine = 1 / std::sqrt(1.25);
    CHECK(felt.at("depth").back() == Approx(height * cosine).epsilon(1e-9));
    CHECK(felt.at("force_x").back() == Approx(-0.5 * kStiffness * height * cosine * cosine).epsilon(1e-9));
    CHECK(felt.at("force_z").back() == Approx(kStiffness * height * cosine * cosine).epsilon(1e-9));
  }
}

TEST_CASE("proxy: the force stays in the cone of friction, at its edge while it slides", "[nodes]") {
  const double friction = 0.4;
  Way way{{0, 0, 0.001}};
  lead(way, {0, 0, -0.003}, 40);
  lead(way, {0.001, 0, -0.003}, 10);  // within 0.4 * 3 mm: it sticks
  const auto held = way.size();
  lead(way, {0.01, 0, -0.003}, 90);
  const auto felt = solid("plane", {{"friction", friction}}).along(way);
  CHECK(felt.at("force_x")[held - 1] == Approx(-kStiffness * 0.001).epsilon(1e-9));
  CHECK(felt.at("slips")[held - 1] == 0);
  CHECK(felt.at("proxy_x")[held - 1] == Approx(0).margin(1e-15));
  CHECK(felt.at("force_x").back() == Approx(-friction * kStiffness * 0.003).epsilon(1e-9));
  CHECK(felt.at("force_z").back() == Approx(kStiffness * 0.003).epsilon(1e-9));
  CHECK(felt.at("slips").back() == 1);
  for (std::size_t n = 0; n < way.size(); ++n)
    REQUIRE(std::abs(felt.at("force_x")[n]) <= friction * felt.at("force_z")[n] * (1 + 1e-9) + 1e-12);
}

TEST_CASE("proxy: the cone of friction holds on solids of all shapes", "[nodes]") {
  const std::string shape = GENERATE("plane", "sphere", "box", "heights");
  Contact contact = solid(shape, {{"friction", 0.5}});
  contact.settings["heights"] = "[0, 0.001, 0.0015, 0.001, 0, 0.0005]";
  contact.settings["columns"] = "3";
  Way way{{0, 0, 0.03}};
  lead(way, {0, 0, shape == "plane" ? -0.002 : shape == "heights" ? -0.001 : 0.018}, 100);
  const auto down = way.back();
  const auto wander = test::noise(9000, 7);
  for (std::size_t n = 0; n < wander.size(); n += 3) {
    auto next = way.back();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double stride = axis == 2 ? 2e-5 : 3e-4, farthest = axis == 2 ? 0.0005 : 0.004;
      next[axis] =
          std::clamp(next[axis] + stride * wander[n + axis], down[axis] - farthest, down[axis] + farthest);
    }
    way.push_back(next);
  }
  const auto felt = contact.along(way);
  int slides = 0;
  for (std::size_t n = 0; n < way.size(); ++n) {
    const double size = std::hypot(felt.at("force_x")[n], felt.at("force_y")[n], felt.at("force_z")[n]);
    const double across = kStiffness * felt.at("depth")[n];
    // F = N / cos(angle): within the cone F <= N sqrt(1 + friction^2).
    REQUIRE(size <= across * std::sqrt(1.25) * (1 + 1e-3) + 1e-9);
    slides += felt.at("slips")[n] > 0;
  }
  CHECK(slides > 10);
}

TEST_CASE("proxy: a device does not get through a thin wall, and is let go where it came in", "[nodes]") {
  // 0.2 mm thick, and the device goes 10 mm behind it; also in steps that are longer than the wall.
  const int steps = GENERATE(4, 21, 1000);
  Way way{{0, 0, 0.01}};
  lead(way, {0, 0, -0.01}, steps);
  const auto pressed = way.size();
  lead(way, {0, 0, 0.01}, steps);
  const auto felt = solid("box", {{"size_z", 0.0001}}).along(way);
  CHECK(felt.at("force_z")[pressed - 1] == Approx(kStiffness * 0.0101).epsilon(1e-9));
  CHECK(felt.at("touches")[pressed - 1] == 1);
  CHECK(felt.at("touches").back() == 0);
  for (const double force : felt.at("force_z")) REQUIRE(force >= 0);
}

TEST_CASE("proxy: it goes around the edge of a wall, not through it", "[nodes]") {
  Way way{{0, 0, 0.01}};
  lead(way, {0, 0, -0.005}, 200);
  lead(way, {0.03, 0, -0.005}, 400);  // past the edge at 20 mm
  const auto passed = way.size();
  lead(way, {0, 0, -0.005}, 400);  // back, behind the wall
  lead(way, {0, 0, 0.0005}, 200);  // up to its other side
  const auto felt = solid("box", {{"size_z", 0.001}}).along(way);
  CHECK(felt.at("touches")[passed - 1] == 0);
  CHECK(felt.at("force_z").back() == Approx(-kStiffness * 0.0015).epsilon(1e-9));
}

TEST_CASE("proxy: slowly around a closed way no solid gives energy", "[nodes]") {
  const std::string shape = GENERATE("plane", "sphere", "box", "heights");
  const double friction = GENERATE(0.0, 0.3);
  INFO(shape << ", friction " << friction);
  Contact contact = solid(shape, {{"friction", friction}});
  contact.settings["heights"] = "[0, 0.001, 0.0015, 0.001, 0]";
  const double surface = shape == "plane" ? 0 : shape == "heights" ? 0.0015 : 0.02;
  Way way{{0, 0, surface + 0.002}};
  lead(way, {0, 0, surface - 0.002}, 4000);
  lead(way, {0.006, 0.002, surface - 0.003}, 4000);
  lead(way, {-0.003, -0.004, surface - 0.001}, 4000);
  lead(way, {0, 0, surface - 0.002}, 4000);
  lead(way, {0, 0, surface + 0.002}, 4000);
  const double given = work(contact.along(way), way);
  const double stored = 0.5 * kStiffness * 0.003 * 0.003;
  CHECK(given < 1e-9 * stored);
  if (friction > 0)
    CHECK(given < -0.1 * stored);
  else  // a ridge of heights keeps the proxy on its side for a while, and takes some
    CHECK(given > (shape == "heights" ? -1e-2 : -1e-4) * stored);
}

TEST_CASE("proxy: heights that make no grid are an error", "[nodes]") {
  const auto& type = test::node_type("proxy");
  const std::map<std::string, test::InputValue> inputs{{"stiffness", 1.0}};
  CHECK(refusal(type, inputs, {{"shape", "heights"}}) != "");
  CHECK(refusal(type, inputs, {{"shape", "heights"}, {"heights", "[0, 1, 2]"}, {"columns", "2"}}) != "");
  CHECK(refusal(type, inputs, {{"shape", "heights"}, {"heights", "[0, 1, 2, 3]"}, {"columns", "2"}}) == "");
}
