#include "latency/calibration.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "latency/estimation/fourier.h"
#include "latency/probe/probe.h"
#include "tests/support/error_summary.h"
#include "tests/support/graphs/plants.h"

namespace {

using namespace tactus;

constexpr int kElectrical = 960;

const std::vector<double>& probe() {
  static const auto samples = stimulus(48_kHz, 0.25);
  return samples;
}

double rms(const std::vector<double>& samples) {
  double sum = 0.0;
  for (const double sample : samples) sum += sample * sample;
  return std::sqrt(sum / static_cast<double>(samples.size()));
}

/// Noise of 20 dB less than what is captured.
double noise_of(const test::Plant& plant) {
  return 0.1 * rms(test::through_plant(plant, probe(), 0, 0.0, 1).captured[0]);
}

Calibration calibration_of(const test::Plant& plant, double noise) {
  CalibrationSettings settings;
  settings.electrical_frames = kElectrical;
  const auto calibration = calibrate(test::through_plant(plant, probe(), kElectrical, noise, 1), settings);
  REQUIRE(calibration);
  return *calibration;
}

test::Plant plant_named(const std::string& name) {
  for (auto& plant : test::plants())
    if (plant.name == name) return plant;
  throw std::runtime_error(name);
}

}  // namespace

TEST_CASE("calibrate: behind a calibrated actuator the engine's delay is right to 0.1 ms", "[latency]") {
  const auto plant = GENERATE(from_range(test::plants()));
  CAPTURE(plant.name);
  const double noise = noise_of(plant);
  const auto calibration = calibration_of(plant, noise);
  CHECK(std::string{code(calibration.finding.verdict)} == "ok");

  const auto later = test::through_plant(plant, probe(), 1234, noise, 7);
  const auto plain = analyze(later);
  REQUIRE(plain);
  CHECK(plain->finding.verdict != Verdict::Ok);  // without the profile it is refused, and not wrong

  AnalysisSettings settings;
  settings.profile = calibration.profile;
  const auto analysis = analyze(later, settings);
  REQUIRE(analysis);
  CHECK(std::string{code(analysis->finding.verdict)} == "ok");
  CHECK(analysis->delay_frames == Approx(1234.0).epsilon(0).margin(4.8));
}

TEST_CASE("calibrate: a woofer's resonance, polarity and air are found", "[latency]") {
  const auto calibration = calibration_of(plant_named("woofer"), 1e-6);
  // f0 = sqrt(k / m) / 2π; Q = sqrt(k m) / (c + Bl² / R)
  REQUIRE(calibration.resonance);
  CHECK(calibration.resonance->frequency_hz ==
        Approx(std::sqrt(1000.0 / 0.035) / (2 * std::numbers::pi)).epsilon(0.05));
  CHECK(calibration.resonance->q == Approx(std::sqrt(1000.0 * 0.035) / (1.2 + 36.0 / 6.5)).epsilon(0.1));
  CHECK(calibration.polarity == 1);
  // 0.25 ms of air, and 0.8 mH / 6.5 ohm of the coil before the swing has a third of its height
  CHECK(calibration.arrival_frames == Approx(12.0).epsilon(0).margin(6.0));
}

TEST_CASE("calibrate: the profile makes of a drive what the plant makes of it", "[latency]") {
  const auto plant = GENERATE(from_range(test::plants()));
  CAPTURE(plant.name);
  const auto taps = calibration_of(plant, 0.0).profile.taps;
  std::vector<double> drive(9600, 0.0);  // a burst of 100 Hz to 2 kHz
  for (std::size_t n = 0; n < 4800; ++n) {
    const double t = static_cast<double>(n) / 48000.0;
    drive[n] = 0.2 * std::sin(2 * std::numbers::pi * (100.0 + 9500.0 * t) * t) *
               std::sin(std::numbers::pi * static_cast<double>(n) / 4800.0);
  }
  const auto captured = test::through_plant(plant, drive, 0, 0.0, 1).captured[0];
  std::vector<double> error(9600);
  for (std::size_t n = 0; n < error.size(); ++n) {
    double sum = 0.0;
    for (std::size_t k = 0; k <= std::min(n, taps.size() - 1); ++k) sum += taps[k] * drive[n - k];
    error[n] = sum - captured[n];
  }
  CHECK(rms(error) < 0.01 * rms({captured.begin(), captured.begin() + 9600}));
}

TEST_CASE("calibrate: a sensor the other way round has the other polarity", "[latency]") {
  auto recording = test::through_plant(plant_named("woofer"), probe(), kElectrical, 1e-6, 1);
  for (auto& sample : recording.captured[0]) sample = -sample;
  CalibrationSettings settings;
  settings.electrical_frames = kElectrical;
  CHECK(calibrate(recording, settings)->polarity == -1);
}

TEST_CASE("calibrate: what is no measurement is refused", "[latency]") {
  CalibrationSettings settings;
  auto recording = test::through_plant(plant_named("woofer"), probe(), 0, 1e-6, 1);
  SECTION("nothing captured") {
    for (auto& sample : recording.captured[0]) sample = 0.0;
    CHECK(calibrate(recording, settings)->finding.verdict == Verdict::NoSignal);
  }
  SECTION("too much noise") {
    recording =
        test::through_plant(plant_named("woofer"), probe(), 0, 3.0 * noise_of(plant_named("woofer")), 1);
    for (auto& sample : recording.captured[0]) sample *= 0.01;  // so that nothing clips
    CHECK(calibrate(recording, settings)->finding.verdict == Verdict::LowSnr);
  }
  SECTION("a delay below zero") {
    settings.electrical_frames = -1.0;
    CHECK(test::summary(calibrate(recording, settings)) == "BadArgument");
  }
}

TEST_CASE("solve_toeplitz: gives back what was multiplied", "[latency]") {
  std::vector<double> r, h, c;
  for (int n = 0; n < 50; ++n) {
    r.push_back(std::pow(0.9, n) + (n == 0 ? 0.1 : 0.0));
    h.push_back(std::sin(0.7 * n) + 0.01 * n);
  }
  for (std::size_t n = 0; n < h.size(); ++n) {
    double sum = 0.0;
    for (std::size_t k = 0; k < h.size(); ++k) sum += r[n > k ? n - k : k - n] * h[k];
    c.push_back(sum);
  }
  const auto solved = solve_toeplitz(r, c);
  for (std::size_t n = 0; n < h.size(); ++n) CHECK(solved[n] == Approx(h[n]).epsilon(0).margin(1e-6));
}
