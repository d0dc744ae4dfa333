#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <filesystem>
#include <numbers>

#include "engine/analysis/pitch_track.h"
#include "engine/scene/measure.h"
#include "tests/support/shipped_scene.h"

using namespace tactus;
using test::play;
using test::Played;

namespace {

void check_expectations_hold(const Played& played) {
  const auto outcomes = check_expectations(played.scene, played.recording);
  REQUIRE(outcomes);
  REQUIRE_FALSE(outcomes->empty());
  for (const auto& outcome : *outcomes) {
    INFO(outcome.name << ": " << outcome.value << ", " << outcome.wanted);
    CHECK(outcome.holds);
  }
}

double peak(const SceneRecording& recording, const char* signal) {
  double most = 0;
  for (const double x : recording.find(signal)->samples) most = std::max(most, std::abs(x));
  return most;
}

/// What sounds on the open string while the bow is on it.
NoteHeard bowed_note(const SceneOptions& options) {
  const auto played = play("cellomobo/open_string.toml", options, 2.5_s);
  const auto melody = melody_of(played.recording);
  return melody.value().notes.at(0);
}

/// Of one frequency, through a Hann window of twenty periods from then on.
double level_at(const SceneRecording& recording, double hertz, double from_s) {
  const auto& x = recording.find("instrument.sound")->samples;
  const double rate = recording.sample_rate.value, length = 20 * rate / hertz;
  const auto first = static_cast<std::size_t>(from_s * rate);
  std::complex<double> sum = 0;
  for (std::size_t n = 0; static_cast<double>(n) < length; ++n) {
    const double at = static_cast<double>(n);
    sum += x[first + n] * (1 - std::cos(2 * std::numbers::pi * at / length)) *
           std::polar(1.0, -2 * std::numbers::pi * hertz / rate * at);
  }
  return std::abs(sum);
}

}  // namespace

TEST_CASE("cellomobo: every scene does what it promises, at short and long delays", "[instruments]") {
  const std::string scene =
      GENERATE("scene", "open_string", "scale", "vibrato", "crescendo", "bow_change", "fingered");
  const double delay_ms = GENERATE(0.0, 20.0, 40.0);
  INFO(scene << " at " << delay_ms << " ms");
  SceneOptions options;
  options.delay = Seconds{delay_ms * 1e-3};
  const auto played = play("cellomobo/" + scene + ".toml", options);
  check_expectations_hold(played);
  CHECK(played.recording.guard.events.empty());
}

TEST_CASE("cellomobo: untouched it is silent, however noisy the piezo and whatever the string",
          "[instruments]") {
  const double g = GENERATE(0.9, 0.99, 0.999);
  INFO("g " << g);
  SceneOptions options;
  options.set["g"] = g;
  options.set["plant.hiss"] = 1e-3 * (1 - g);
  const auto played = play("cellomobo/untouched.toml", options);
  CHECK(peak(played.recording, "instrument.shaker") < 1e-4);
  CHECK(peak(played.recording, "instrument.sound") < 1e-4);
}

TEST_CASE("cellomobo: aligned each open string speaks in tune within half a second", "[instruments]") {
  const double hertz = GENERATE(110.0, 220.0, 440.0, 880.0), delay_ms = GENERATE(0.0, 10.0, 20.0, 30.0);
  INFO(hertz << " Hz, " << delay_ms << " ms");
  SceneOptions options;
  options.delay = Seconds{delay_ms * 1e-3};
  options.set["open_pitch"] = hertz;
  options.set["wanted.open_pitch"] = hertz;
  const auto note = bowed_note(options);
  CHECK(note.partial == 1);
  CHECK(std::abs(note.cents) < 1);
  REQUIRE(note.speaks_after_s);
  CHECK(*note.speaks_after_s < 0.5);
}

TEST_CASE("cellomobo: the bow off, the string dies as the inner loop alone", "[instruments]") {
  // T60 = 3 (N / rate) / -log10(g |H_LP|), |H_LP| = 0.99998 at 110 Hz.
  const double g = 0.9, t60 = 3 / 110.0 / -std::log10(g * 0.99998);
  SceneOptions options;
  options.set["g"] = g;
  const auto recording = play("cellomobo/open_string.toml", options).recording;
  const double fell = 20 * std::log10(level_at(recording, 110, 2.65) / level_at(recording, 110, 2.95));
  CHECK(60 * 0.3 / fell == Approx(t60).epsilon(0.05));
}

TEST_CASE("cellomobo: without alignment the bow's direction decides what sounds", "[instruments]") {
  // Friction turns around with the bow, and the loop's sign with it: half a turn, half a spacing of its
  // modes.
  SceneOptions options;
  options.set["align"] = 0.0;
  std::vector<double> heard;
  for (const double polarity : {1.0, -1.0}) {
    options.set["polarity"] = polarity;
    heard.push_back(bowed_note(options).heard_hz);
  }
  CHECK(heard[0] == Approx(110).epsilon(0.002));
  CHECK(std::abs(heard[1] / 110 - 1) > 0.01);
}

TEST_CASE("carrier_sensor: resolution and delay through a card without direct current", "[instruments]") {
  const double delay_ms = GENERATE(0.0, 20.0, 40.0);
  SceneOptions options;
  options.delay = Seconds{delay_ms * 1e-3};
  check_expectations_hold(play("parts/carrier_sensor_scene.toml", options));
}
