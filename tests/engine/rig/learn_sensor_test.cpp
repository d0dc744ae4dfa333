#include "engine/rig/learn_sensor.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "engine/nodes/table.h"
#include "engine/scene/play_scene.h"
#include "tests/support/error_summary.h"

using namespace tactus;

namespace {

constexpr double kRate = 48000;
using Samples = std::vector<double>;

double ratio(double db) { return std::pow(10.0, db / 20); }

/// Half a second each: quiet, then a struck 800 Hz that rings away, with noise over all of it.
Samples hits(const std::vector<double>& peaks_db, double noise_rms_db = -90, double ring_s = 0.02) {
  Samples samples;
  std::mt19937 bits{1};
  std::normal_distribution<double> noise{0, ratio(noise_rms_db)};
  for (const double db : peaks_db)
    for (int n = 0; n < 24000; ++n) {
      const double t = n / kRate - 0.2;
      const double hit =
          t < 0 ? 0 : ratio(db) * std::cos(2 * std::numbers::pi * 800 * t) * std::exp(-t / ring_s);
      samples.push_back(hit + noise(bits));
    }
  return samples;
}

Result<LearntSensor> learn(const Samples& samples, std::size_t block = 64) {
  SensorLearner learner{Hertz{kRate}};
  for (std::size_t n = 0; n < samples.size(); n += block)
    learner.process({samples.data() + n, std::min(block, samples.size() - n)});
  return learner.result();
}

std::string refusal(const Samples& samples) {
  const auto learnt = learn(samples);
  return test::summary(learnt);
}

}  // namespace

TEST_CASE("learn: five soft hits at -35 dB count as -20 dB of full scale", "[rig]") {
  const auto block = GENERATE(std::size_t{1}, std::size_t{64}, std::size_t{1000});
  const auto learnt = learn(hits({-35, -33, -35, -37, -35}), block);
  REQUIRE(learnt);
  // The detector's high-pass takes a little off the first, highest half wave.
  CHECK(20 * std::log10(learnt->soft) == Approx(-35).margin(0.5));
  CHECK(20 * std::log10(learnt->full_scale) == Approx(20 * std::log10(learnt->soft) + 20));
  // Median over 10 ms of the highest of 480 Gaussian samples: 3 sigma and a little.
  CHECK(20 * std::log10(learnt->noise) == Approx(-90 + 20 * std::log10(3.2)).margin(1));
}

TEST_CASE("learn: what rings for long counts once a hit, and other gains shift only the result", "[rig]") {
  const auto gain_db = GENERATE(-40.0, -20.0, 0.0);
  const auto learnt =
      learn(hits({gain_db - 15, gain_db - 15, gain_db - 15, gain_db - 15, gain_db - 15}, -95, 0.1));
  INFO((learnt ? "" : to_string(learnt.error())));
  REQUIRE(learnt);
  CHECK(20 * std::log10(learnt->soft) == Approx(gain_db - 15).margin(0.5));
}

TEST_CASE("learn: hits that do not stand out, clip or differ are refused in words", "[rig]") {
  CHECK(refusal(hits({-34, -34, -34, -34, -34}, -52)) == "OutOfRange 9 12");
  CHECK(refusal(hits({-30, -30, 1, -30, -30})) == "OutOfRange");
  CHECK(refusal(hits({-30, -30, -44, -30, -30})) == "OutOfRange 14 12");
  CHECK(refusal(hits({-30, -30, -30})) == "Missing 3 5");
  CHECK(refusal(hits({})) == "Missing 5");
  CHECK(refusal(hits({-200, -200, -200, -200, -200}, -60)) == "Missing 5");
}

TEST_CASE("learn: the simulated drum, struck softly, then has -20 dB", "[rig]") {
  const std::filesystem::path instruments = std::string{TACTUS_SOURCE_DIR} + "/instruments";
  const auto scene = load_scene(instruments / "haptic_drum/single_strike.toml", instruments);
  REQUIRE(scene);
  Samples all;
  // The first comes before the noise is known.
  for (const double height : {0.020, 0.020, 0.018, 0.022, 0.020, 0.021}) {
    auto built = build_scene(*scene, standard_nodes(),
                             {.delay = {}, .rate = {}, .set = {{"plant.drop_height", ControlValue{height}}}});
    REQUIRE(built);
    auto once = *scene;
    once.duration = Seconds{0.6};
    const auto recording = play_scene(once, *built, 256);
    REQUIRE(recording);
    const auto& strike = recording->find("instrument.microphone")->samples;
    all.insert(all.end(), strike.begin(), strike.end());
  }
  const auto learnt = learn(all);
  INFO((learnt ? "" : to_string(learnt.error())));
  REQUIRE(learnt);
  for (auto& sample : all) sample /= learnt->full_scale;
  const auto again = learn(all);
  REQUIRE(again);
  CHECK(20 * std::log10(again->soft) == Approx(-20).margin(1e-6));
}

TEST_CASE("learn: what was learnt becomes the sensitivity of a plain port", "[rig]") {
  Rig rig;
  rig.inputs.emplace_back();
  rig.inputs[0].name = "microphone";
  REQUIRE(use_learnt(rig, "microphone", {0.01, 0.0001, 0.1}, {}));
  CHECK(rig.inputs[0].scale() == Approx(10));  // a sample of 0.1 is full scale
  CHECK(*rig.inputs[0].volts == 1.0);
  rig.inputs[0].volts = 4.0;
  REQUIRE(use_learnt(rig, "microphone", {0.01, 0.0001, 0.1}, {}));
  CHECK(rig.inputs[0].sensitivity->si == Approx(0.4));
  CHECK(test::summary(use_learnt(rig, "microphone", {}, parse_unit("N")->dimension)) ==
        "UnitMismatch 'microphone'");
}
