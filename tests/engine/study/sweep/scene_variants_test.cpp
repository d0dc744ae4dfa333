#include "engine/study/sweep/scene_variants.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <set>

#include "engine/core/dimension.h"
#include "engine/nodes/table.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/play_scene.h"

using namespace tactus;

namespace {

const std::filesystem::path kInstruments = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments";

SceneSpec drum() {
  auto scene = load_scene(kInstruments / "haptic_drum" / "scene.toml", kInstruments);
  if (!scene) throw std::runtime_error(to_string(scene.error()));
  scene->duration = Seconds{0.3};
  return *scene;
}

std::uint64_t print_of(const SceneSpec& scene) {
  Fingerprint print;
  return add(print, scene).value();
}

/// The factor in front of a field of an element, 1 if there is none.
double factor_of(const SceneSpec& scene, const std::string& element, const std::string& field) {
  for (const auto& candidate : scene.part("plant")->graph->networks.front().elements) {
    if (candidate.name != element) continue;
    const auto* value = find(candidate.fields, field);
    if (const auto* number = value->number()) return *number;
    const auto text = *value->text();
    return text.find(" * (") == std::string::npos ? 1 : std::stod(text);
  }
  throw std::runtime_error("no such element");
}

std::vector<double> cone_of(const SceneSpec& scene) {
  auto built = build_scene(scene, standard_nodes());
  if (!built) throw std::runtime_error(to_string(built.error()));
  return play_scene(scene, *built, 256)->find("plant.cone")->samples;
}

}  // namespace

TEST_CASE("scene variants: another plant has its own quantities, the same for the same seed", "[analysis]") {
  const auto scene = drum();
  std::set<double> factors;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto drawn = with_plant_drawn(scene, 0.2, seed);
    CHECK(print_of(drawn) == print_of(with_plant_drawn(scene, 0.2, seed)));
    CHECK(build_scene(drawn, standard_nodes()).has_value());
    for (const auto* field : {"stiffness", "loss"}) {
      const double factor = factor_of(drawn, "lens", field);
      CHECK(std::abs(factor - 1) <= 0.2);
      factors.insert(factor);
    }
    CHECK(factor_of(drawn, "stick", "mass") != 1);
    CHECK(factor_of(drawn, "coil", "force_factor") != 1);
  }
  CHECK(factors.size() == 40);
}

TEST_CASE("scene variants: places, exponents and signals stay as they are written", "[analysis]") {
  const auto drawn = with_plant_drawn(drum(), 0.2, 1);
  CHECK(factor_of(drawn, "lens", "exponent") == 1.5);
  CHECK(factor_of(drawn, "stick", "at") == 1);
  CHECK(factor_of(drawn, "coil", "voltage") == 1);
  CHECK(factor_of(drawn, "hand", "force") == 1);
}

// Mean and variance of a uniform number within a fifth: 1 and 0.2^2 / 3. Of 1000 the mean is off by 0.0037.
TEST_CASE("scene variants: draws are even", "[analysis]") {
  const auto scene = drum();
  double sum = 0, squares = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const double off = factor_of(with_plant_drawn(scene, 0.2, seed), "cone", "mass") - 1;
    sum += off;
    squares += off * off;
  }
  CHECK(sum / 1000 == Approx(0).margin(4 * 0.0037));
  CHECK(squares / 1000 == Approx(0.04 / 3).epsilon(0.1));
}

// Before the first throw nothing differs; its very first push is linear in the gain.
TEST_CASE("scene variants: an actuator twice as strong moves the cone twice as far at first", "[analysis]") {
  auto scene = drum();
  scene.delay = 40_ms;  // by then the stick is in the air
  const auto still = cone_of(with_actuator_gain(scene, 1e-9)), plain = cone_of(scene),
             strong = cone_of(with_actuator_gain(scene, 2));
  std::size_t first = 0;
  while (first < plain.size() && std::abs(plain[first] - still[first]) < 1e-9) ++first;
  REQUIRE(first + 24 < plain.size());
  const auto moved = [&](const std::vector<double>& cone) { return cone[first + 24] - still[first + 24]; };
  CHECK(moved(strong) / moved(plain) == Approx(2).epsilon(1e-3));
}

TEST_CASE("scene variants: a gesture is scaled at all its points", "[analysis]") {
  const auto scaled = with_gesture_scaled(drum(), "weight", 2);
  CHECK(scaled.gesture("weight")->points.front().value == Approx(0.7));
}

TEST_CASE("scene variants: a gesture that is held stays at one value", "[analysis]") {
  const auto held = with_gesture_held(drum(), "weight", 0.5);
  REQUIRE(held.gesture("weight")->points.size() == 1);
  CHECK(held.gesture("weight")->points.front().value == 0.5);
}

TEST_CASE("scene fingerprint: what is played counts, texts for people do not", "[analysis]") {
  const auto scene = drum();
  auto named = scene;
  named.name = "another";
  named.about = "other text";
  CHECK(print_of(named) == print_of(scene));
  auto later = scene;
  later.delay = 21_ms;
  CHECK(print_of(later) != print_of(scene));
  CHECK(print_of(with_gesture_scaled(scene, "weight", 1.001)) != print_of(scene));
  CHECK(print_of(with_actuator_gain(scene, 1.001)) != print_of(scene));
  CHECK(print_of(with_plant_drawn(scene, 0.2, 2)) != print_of(with_plant_drawn(scene, 0.2, 3)));
}
