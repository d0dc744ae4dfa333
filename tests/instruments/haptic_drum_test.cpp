#include <catch2/catch.hpp>
#include <filesystem>

#include "engine/graph/file/load.h"
#include "engine/scene/measures/measure.h"
#include "tests/support/optional_files.h"
#include "tests/support/shipped_scene.h"

using namespace tactus;
using test::kInstruments;
using test::play;
using test::Played;

namespace {

double ask(const Played& played, const char* measure_name, const char* of, double from, double to) {
  Expectation expectation;
  expectation.measure = measure_name;
  expectation.of = of;
  expectation.from_s = from;
  expectation.to_s = to;
  const auto value = measure(played.recording, expectation);
  if (!value) throw std::runtime_error(to_string(value.error()));
  return *value;
}

}  // namespace

TEST_CASE("instruments: every scene does what it expects of itself", "[instruments]") {
  for (const auto& file : std::filesystem::recursive_directory_iterator(kInstruments)) {
    if (file.path().extension() != ".toml" || test::is_left_out(file.path())) continue;
    const auto table = load_toml(file.path());
    REQUIRE(table);
    if (find(*table, "parts") == nullptr) continue;
    INFO(file.path().string());
    const auto played = play(file.path());
    CHECK_FALSE((played.scene.expect.empty() && played.scene.accuracy.empty()));
    const auto outcomes = check_expectations(played.scene, played.recording);
    REQUIRE(outcomes);
    for (const auto& outcome : *outcomes) {
      INFO(outcome.name << ": " << outcome.value << ", " << outcome.wanted);
      CHECK(outcome.holds);
    }
  }
}

// The interval is 1 / roll_rate, and the spread of an even roll is 0: the map from one landing to the next
// has a fixed point at the wanted interval. Before the first second the drum tosses the stick, to find out
// how strongly the hand presses. With this hand, of 0.35 N, the woofer's excursion allows no less than 11
// strokes a second.
TEST_CASE("haptic drum: the roll is even at its rate, at 0, 10, 20 and 30 ms of delay", "[instruments]") {
  const auto delay = GENERATE(0_ms, 10_ms, 20_ms, 30_ms);
  const double rate = GENERATE(12.0, 20.0);
  INFO("delay " << delay.value * 1e3 << " ms, " << rate << " strokes a second");
  SceneOptions options;
  options.delay = delay;
  options.set["roll_rate"] = rate;
  const auto played = play(kInstruments / "haptic_drum" / "scene.toml", options);
  CHECK(ask(played, "rate", "plant.contact", 1, 12) == Approx(rate).epsilon(0.01));
  CHECK(ask(played, "spread", "plant.contact", 1, 12) < 0.01);
  CHECK(ask(played, "faults", "", 0, 12) == 0);
}

// A flight that begins with v = e w + (1 + e) u, where the stick falls with w = g T / 2, lasts T = 2 v / g,
// so T = 2 (1 + e) u / (g (1 - e)), e = 0.475 - 0.06 s/m (w + u). The hand of 0.35 N pulls the 12.5 g with g.
TEST_CASE("haptic drum: when the hand leads, its force decides the rate", "[instruments]") {
  constexpr double kThrow = 0.3, kGravity = 0.35 / 0.0125;
  double flight = 0.05;
  for (int i = 0; i < 50; ++i) {
    const double bounce = 0.475 - 0.06 * (kGravity * flight / 2 + kThrow);
    flight = 2 * (1 + bounce) * kThrow / (kGravity * (1 - bounce));
  }
  const auto [delay, rate] = GENERATE(table<Seconds, double>({{0_ms, 12.0}, {20_ms, 24.0}, {30_ms, 20.0}}));
  INFO("delay " << delay.value * 1e3 << " ms, " << rate << " strokes a second asked for and not heeded");
  SceneOptions options;
  options.delay = delay;
  options.set["hand_leads"] = 1;
  options.set["roll_rate"] = rate;
  const auto played = play(kInstruments / "haptic_drum" / "scene.toml", options);
  CHECK(ask(played, "rate", "plant.contact", 1, 12) == Approx(1 / flight).epsilon(0.06));
  CHECK(ask(played, "spread", "plant.contact", 1, 12) < 0.01);
}

TEST_CASE("haptic drum: without the throw a bounce is over by 0.2 s", "[instruments]") {
  SceneOptions options;
  options.set["strength"] = 0;
  const auto dead = play(kInstruments / "haptic_drum" / "scene.toml", options);
  CHECK(ask(dead, "last", "instrument.hit", 0, 12) < 0.2);
  CHECK(ask(dead, "last", "plant.contact", 0, 12) < 0.2);
}

// Ground truth is the contact force of the plant. Sound travels 0.3 ms, and the detector has 1 ms.
TEST_CASE("haptic drum: each stroke of a roll is detected once, within 1.3 ms of the first push",
          "[instruments]") {
  const auto delay = GENERATE(0_ms, 10_ms, 20_ms);
  INFO("delay " << delay.value * 1e3 << " ms");
  SceneOptions options;
  options.delay = delay;
  const auto played = play(kInstruments / "haptic_drum" / "scene.toml", options);
  CHECK(ask(played, "count", "instrument.hit", 1, 12) > 200);
  CHECK(ask(played, "missed", "instrument.hit", 1, 12) == 0);
  CHECK(ask(played, "doubled", "instrument.hit", 1, 12) == 0);
  CHECK(ask(played, "detection_time", "instrument.hit", 1, 12) <= 1.3e-3);
}
