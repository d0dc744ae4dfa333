#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <filesystem>
#include <numbers>

#include "engine/scene/measures/measure.h"
#include "engine/scene/measures/notes/pitch_track.h"
#include "engine/study/sweep/scene_variants.h"
#include "tests/support/shipped_scene.h"

using namespace tactus;
using test::play;
using test::Played;
using test::shipped_scene;

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
DetectedNote bowed_note(const SceneOptions& options) {
  const auto played = play("cellomobo/open_string.toml", options, 2.5_s);
  const auto melody = melody_of(played.recording);
  return melody.value().notes.at(0);
}

/// The open string, tuned to a pitch and bowed so many times as hard and as fast; to the end of the stroke.
SceneRecording bowed(double hertz, double force = 1, double speed = 1, const SceneOptions& options = {}) {
  auto scene = with_gesture_held(shipped_scene("cellomobo/open_string.toml"), "tuned", hertz);
  scene = with_gesture_scaled(with_gesture_scaled(std::move(scene), "weight", force), "stroke", speed);
  scene.duration = 2.5_s;
  return play(scene, options);
}

double level_db(const SceneRecording& played) {
  const auto& sound = played.find("instrument.sound")->samples;
  double squares = 0;
  const auto from = sound.size() / 2;
  for (auto n = from; n < sound.size(); ++n) squares += sound[n] * sound[n];
  return 10 * std::log10(squares / static_cast<double>(sound.size() - from));
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

TEST_CASE("cellomobo: every scene does what it promises, at short and long delays", "[instruments][slow]") {
  const std::string scene =
      GENERATE("scene", "open_string", "scale", "vibrato", "crescendo", "bow_change", "octave", "fingered",
               "fast_scale", "wide_vibrato", "pizzicato", "double_stops");
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

TEST_CASE("cellomobo: the open string does what it promises with every gain of the string", "[instruments]") {
  SceneOptions options;
  options.set["g"] = GENERATE(0.9, 0.97, 0.999);
  INFO("g " << options.set["g"].si);
  check_expectations_hold(play("cellomobo/open_string.toml", options));
}

TEST_CASE("cellomobo: from A2 to B5 all levels are within 6 dB", "[instruments][slow]") {
  SceneOptions options;
  options.delay = Seconds{GENERATE(0.0, 20.0, 40.0) * 1e-3};
  std::vector<double> levels;
  for (const double hertz : {110.0, 165.0, 220.0, 330.0, 440.0, 660.0, 880.0, 987.77})
    levels.push_back(level_db(bowed(hertz, 1, 1, options)));
  const auto [low, high] = std::minmax_element(levels.begin(), levels.end());
  CHECK(*high - *low < 6);
  CHECK(*low > -35);
}

// The sound is friction times the root of friction, force and speed: mu(v) sqrt(mu(v) N v), with
// mu(v) = 0.3 (1 + exp(-v / 0.05 m/s)).
TEST_CASE("cellomobo: the sound follows the force and the speed of the bow", "[instruments]") {
  const auto friction = [](double v) { return 0.3 * (1 + std::exp(-v / 0.05)); };
  const auto theory = [&](double force, double speed) {
    const double ratio = friction(0.1 * speed) / friction(0.1);
    return 20 * std::log10(ratio * std::sqrt(ratio * force * speed));
  };
  const double hertz = GENERATE(147.0, 440.0);
  const double normal = level_db(bowed(hertz));
  for (const double factor : {0.25, 4.0}) {
    INFO(hertz << " Hz, " << factor);
    CHECK(level_db(bowed(hertz, factor, 1)) - normal == Approx(theory(factor, 1)).epsilon(0).margin(1.5));
    CHECK(level_db(bowed(hertz, 1, factor)) - normal == Approx(theory(1, factor)).epsilon(0).margin(1.5));
  }
  CHECK(level_db(bowed(hertz, 2, 3)) > level_db(bowed(hertz, 1, 3)) + 2);
}

TEST_CASE("cellomobo: a finger that presses harder brightens the sound", "[instruments]") {
  // H_2LP is a Butterworth low-pass at 1.5 or 4 times the pitch: of partial 3, -12.3 or -1.2 dB.
  const auto third = [](double pressure) {
    auto scene = with_gesture_held(shipped_scene("cellomobo/open_string.toml"), "press", pressure);
    scene.duration = 2.5_s;
    const auto played = play(scene);
    return 20 * std::log10(level_at(played, 330, 2.0) / level_at(played, 110, 2.0));
  };
  const auto low_pass = [](double at) { return -10 * std::log10(1 + std::pow(at, 4)); };
  const double theory = low_pass(3 / 4.0) - low_pass(3 / 1.5) - (low_pass(1 / 4.0) - low_pass(1 / 1.5));
  CHECK(third(0.99) - third(0.0) == Approx(theory).epsilon(0).margin(1.0));
}

TEST_CASE("cellomobo: a bow that turns on a high note is no louder than the note", "[instruments]") {
  auto scene = with_gesture_held(shipped_scene("cellomobo/bow_change.toml"), "finger", 0.60375);  // A5
  SceneOptions options;
  options.set["g"] = GENERATE(0.9, 0.99);
  const auto played = play(scene, options);
  const auto& sound = played.find("instrument.sound")->samples;
  const auto loudest = [&](double from_s, double to_s) {
    double most = 0;
    for (auto n = static_cast<std::size_t>(from_s * 48000); n < static_cast<std::size_t>(to_s * 48000); ++n)
      most = std::max(most, std::abs(sound[n]));
    return most;
  };
  CHECK(loudest(0.0, played.seconds() - 0.01) < 2 * loudest(0.7, 0.9));
}

TEST_CASE("cellomobo: a slur down by less than an octave takes nothing from the note", "[instruments]") {
  const auto played = play("cellomobo/scene.toml");  // from C#4 up to A4 and down again
  const auto level = [&](double from_s, double to_s) {
    const auto& sound = played.recording.find("instrument.sound")->samples;
    double squares = 0;
    const auto first = static_cast<std::size_t>(from_s * 48000),
               last = static_cast<std::size_t>(to_s * 48000);
    for (auto n = first; n < last; ++n) squares += sound[n] * sound[n];
    return 10 * std::log10(squares / static_cast<double>(last - first));
  };
  CHECK(level(5.35, 5.58) == Approx(level(3.75, 4.35)).epsilon(0).margin(6));  // E4
  CHECK(level(5.75, 5.98) == Approx(level(3.35, 3.58)).epsilon(0).margin(6));  // C#4
}

// Where friction falls faster with the speed than the mount resists, the mount rubs by itself: from
// N = c v_s exp(v / v_s) / 0.3 on, c = 2 zeta m omega = 12.1 N s/m, at 0.02 m/s 3.0 N.
TEST_CASE("cellomobo: a bow is too heavy for its speed where the mount loses its damping", "[instruments]") {
  const double border = 2 * 0.1 * 0.008 * 2 * std::numbers::pi * 1200 * 0.05 * std::exp(0.02 / 0.05) / 0.3;
  const auto first_note = [&](double newtons) {
    const auto played = bowed(440, newtons / 0.5, 0.2);
    const auto melody = melody_of(played);
    return melody.value().notes.at(0);
  };
  const auto below = first_note(0.85 * border), above = first_note(1.15 * border);
  CHECK(below.partial == 1);
  CHECK(std::abs(below.cents) < 5);
  CHECK((above.partial != 1 || std::abs(above.cents) > 25));
}

TEST_CASE("cellomobo: on a flat plant the fundamental wins at every note and delay", "[instruments][slow]") {
  const double hertz = GENERATE(55.0, 110.0, 440.0, 880.0), g = GENERATE(0.9, 0.99);
  for (const double delay_ms : {0.0, 1.22, 7.0, 20.0, 40.0}) {
    INFO(hertz << " Hz, g " << g << ", " << delay_ms << " ms");
    SceneOptions options;
    options.delay = Seconds{delay_ms * 1e-3};
    options.set["g"] = g;
    const auto played =
        play(with_gesture_held(shipped_scene("cellomobo/flat.toml"), "tuned", hertz), options);
    const auto melody = melody_of(played);
    const auto& note = melody.value().notes.at(0);
    CHECK(note.partial == 1);
    CHECK(std::abs(note.cents) < 0.5);
    // The lower the note, the slower a string of this gain builds up.
    CHECK(note.speaks_after_s.value() < (hertz < 100 ? 0.6 : 0.5));
  }
}

TEST_CASE("cellomobo: without alignment the bow's direction decides what sounds", "[instruments]") {
  // Friction turns around with the bow, and the loop's sign with it: half a turn, half a spacing of its
  // modes.
  SceneOptions options;
  options.set["align"] = 0.0;
  std::vector<double> pitches;
  for (const double polarity : {1.0, -1.0}) {
    options.set["polarity"] = polarity;
    pitches.push_back(bowed_note(options).detected_hz);
  }
  CHECK(std::abs(cents(pitches[0], pitches[1])) > 20);
}

TEST_CASE("carrier_sensor: given its value at full, it is right whatever the card's gain", "[instruments]") {
  // 3 % less would be 345 mm read as 334.65 mm: 52 cents flat.
  SceneOptions options;
  options.set["ribbon.gain"] = 0.97;
  const auto flat = play("cellomobo/fingered.toml", options);
  CHECK(melody_of(flat.recording).value().notes.at(3).cents < -45);
  options.set["full"] = 0.97;
  check_expectations_hold(play("cellomobo/fingered.toml", options));
}

TEST_CASE("carrier_sensor: resolution and delay through a card without direct current", "[instruments]") {
  const double delay_ms = GENERATE(0.0, 20.0, 40.0);
  SceneOptions options;
  options.delay = Seconds{delay_ms * 1e-3};
  check_expectations_hold(play("parts/carrier_sensor_scene.toml", options));
}
