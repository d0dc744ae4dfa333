#include "engine/scene/measures/measure.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace tactus;

namespace {

/// Half a second of 220 Hz with a second partial, then half a second of silence.
SceneRecording sung() {
  SceneRecording recording;
  recording.sample_rate = 48_kHz;
  RecordedSignal sound{"instrument.sound", {}, std::vector<double>(48000, 0.0)};
  for (std::size_t n = 0; n < 24000; ++n) {
    const double turns = 220.0 * static_cast<double>(n) / 48000;
    sound.samples[n] = std::sin(2 * std::numbers::pi * turns) + 0.4 * std::sin(4 * std::numbers::pi * turns);
  }
  recording.signals.push_back(std::move(sound));
  return recording;
}

double pitch(const SceneRecording& recording, double from_s, double to_s) {
  Expectation expectation;
  expectation.measure = "pitch";
  expectation.of = "instrument.sound";
  expectation.from_s = from_s;
  expectation.to_s = to_s;
  return measure(recording, expectation).value();
}

}  // namespace

namespace {

/// A ball that lands on a table at rest with these speeds in turn: parabolas, cut where they touch.
SceneRecording bounces(const std::vector<double>& speeds, int landings) {
  constexpr double kGravity = 9.81, kRate = 48000;
  SceneRecording recording;
  recording.sample_rate = Hertz{kRate};
  RecordedSignal ball{"plant.ball", parse_unit("m")->dimension, {}};
  double begins = 0;  // of a flight
  for (int i = 0; i <= landings; ++i) {
    // What leaves with v comes back with v.
    const double speed = speeds[static_cast<std::size_t>(i) % speeds.size()], lasts = 2 * speed / kGravity;
    while (static_cast<double>(ball.samples.size()) / kRate < begins + lasts) {
      const double t = static_cast<double>(ball.samples.size()) / kRate - begins;
      ball.samples.push_back(speed * t - 0.5 * kGravity * t * t);
    }
    begins += lasts;
    ball.samples.push_back(-1e-6);
    begins = static_cast<double>(ball.samples.size()) / kRate;
  }
  recording.signals = {std::move(ball), {"plant.table", parse_unit("m")->dimension, {}}};
  recording.roles = {{"ball", "plant.ball", {}}, {"table", "plant.table", {}}};
  recording.signals[1].samples.assign(recording.signals[0].samples.size(), 0.0);
  return recording;
}

double period(const SceneRecording& recording) {
  Expectation expectation;
  expectation.measure = "period";
  return measure(recording, expectation).value();
}

}  // namespace

TEST_CASE("measure: the landings after which a ball does the same again", "[scene]") {
  CHECK(period(bounces({0.2}, 12)) == 1);
  CHECK(period(bounces({0.2, 0.23}, 12)) == 2);
  CHECK(period(bounces({0.2, 0.23, 0.21, 0.24}, 20)) == 4);
  // Ten different ones; then too few landings to say.
  CHECK(period(bounces({0.2, 0.23, 0.21, 0.24, 0.18, 0.29, 0.17, 0.26, 0.15, 0.3}, 40)) == 0);
  CHECK(period(bounces({0.2, 0.23}, 3)) == 0);
}

TEST_CASE("measure: a ball without its table is an error in words", "[scene]") {
  auto recording = bounces({0.2}, 12);
  recording.signals.pop_back();
  Expectation expectation;
  expectation.measure = "period";
  CHECK_FALSE(measure(recording, expectation).has_value());
}

TEST_CASE("measure: the pitch of a part of a signal, 0 where it has none", "[scene]") {
  const auto recording = sung();
  // 0.1 cent.
  CHECK(pitch(recording, 0.1, 0.4) == Approx(220).epsilon(6e-5));
  CHECK(pitch(recording, 0.6, 0.9) == 0);
}

// Peak over root mean square: sqrt(2) of a sine over whole periods, 1 of a square, 0 by definition of
// silence.
TEST_CASE("measure: the crest factor of a sine, a square and silence", "[scene]") {
  SceneRecording recording;
  recording.sample_rate = 48_kHz;
  recording.signals = {{"plant.sine", {}, {}}, {"plant.square", {}, {}}, {"plant.silence", {}, {}}};
  for (int n = 0; n < 48000; ++n) {
    const double turns = 100.0 * n / 48000;  // 480 frames a period, of which one is the crest
    recording.signals[0].samples.push_back(3 * std::sin(2 * std::numbers::pi * turns));
    recording.signals[1].samples.push_back(turns - std::floor(turns) < 0.5 ? 2.0 : -2.0);
    recording.signals[2].samples.push_back(0);
  }
  const auto crest_factor = [&](const char* signal) {
    Expectation expectation;
    expectation.measure = "crest_factor";
    expectation.of = signal;
    return measure(recording, expectation).value();
  };
  CHECK(crest_factor("plant.sine") == Approx(std::numbers::sqrt2).epsilon(1e-12));
  CHECK(crest_factor("plant.square") == 1);
  CHECK(crest_factor("plant.silence") == 0);
}
