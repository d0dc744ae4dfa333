#include "engine/scene/measures/notes/pitch_track.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/scene/measures/playability_result.h"
#include "tests/support/reading.h"

using namespace tactus;
using tactus::test::reading;

namespace {

constexpr Hertz kRate{48000};

/// A sine whose frequency follows `hertz`, silent where that is 0.
std::vector<double> sung(const std::vector<double>& hertz) {
  std::vector<double> x(hertz.size());
  double turns = 0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    x[n] = hertz[n] > 0 ? std::sin(2 * std::numbers::pi * turns) : 0.0;
    turns += hertz[n] / kRate.value;
  }
  return x;
}

std::vector<double> steps(const std::vector<double>& hertz, double seconds) {
  std::vector<double> all;
  for (const double one : hertz) all.insert(all.end(), static_cast<std::size_t>(seconds * kRate.value), one);
  return all;
}

/// Half a second of each, and so many seconds from one to the other on a straight line of cents.
std::vector<double> slide(double from_hz, double to_hz, double seconds) {
  auto all = steps({from_hz}, 0.5);
  const auto frames = static_cast<std::size_t>(seconds * kRate.value);
  for (std::size_t n = 0; n < frames; ++n)
    all.push_back(from_hz * std::pow(to_hz / from_hz, static_cast<double>(n) / static_cast<double>(frames)));
  all.insert(all.end(), static_cast<std::size_t>(0.5 * kRate.value), to_hz);
  return all;
}

std::vector<double> vibrato(double hertz, double depth_cents, double seconds) {
  auto all = steps({hertz}, seconds);
  for (std::size_t n = 0; n < all.size(); ++n)
    all[n] *= std::exp2(depth_cents / 1200 *
                        std::sin(2 * std::numbers::pi * 5 * static_cast<double>(n) / kRate.value));
  return all;
}

std::vector<DetectedNote> detected_of(const std::vector<double>& samples,
                                      const std::vector<double>& expected) {
  return detect_notes(track_pitch(samples, kRate, 50_Hz, 1500_Hz), expected, kRate);
}
std::vector<DetectedNote> detected(const std::vector<double>& played, const std::vector<double>& expected) {
  return detected_of(sung(played), expected);
}

}  // namespace

TEST_CASE("pitch track: each wanted note with its cents and partial", "[analysis]") {
  const double up = std::exp2(7.0 / 1200);
  const auto notes = detected(steps({110, 220 * up, 3 * 165, 0}, 0.5), steps({110, 220, 165, 330}, 0.5));
  REQUIRE(notes.size() == 4);
  CHECK(notes[0].partial == 1);
  CHECK(notes[0].cents == Approx(0).margin(0.1));
  CHECK(notes[1].partial == 1);
  CHECK(notes[1].cents == Approx(7).epsilon(0).margin(0.1));
  CHECK(notes[2].partial == 3);
  CHECK(notes[2].cents == Approx(0).margin(0.1));
  CHECK(describe(notes[2]).starts_with("E3, 165.0 Hz: not right: 495.0 Hz sounds, partial 3, "));
  CHECK(notes[3].detected_hz == 0);
  CHECK(notes[3].expected.from_s == Approx(1.5));
  CHECK(describe(notes[3]) == "E4, 330.0 Hz: no pitched sound");
  CHECK(describe(notes) == "2 of 4 notes right, at most 7.0 cents off, each steady within 0.03 s");
}

TEST_CASE("pitch track: a note that takes long to leave another partial is reported so and not right",
          "[analysis]") {
  for (const double wrong_s : {0.2, 0.3}) {
    auto played = steps({220}, 1.0);
    for (std::size_t n = 0; n < static_cast<std::size_t>(wrong_s * kRate.value); ++n) played[n] = 440;
    const auto notes = detected(played, steps({220}, 1.0));
    REQUIRE(notes.size() == 1);
    REQUIRE(notes[0].speaks_after_s);
    // The tracker sees six periods at once, 27 ms.
    CHECK(*notes[0].speaks_after_s == Approx(wrong_s).epsilon(0).margin(0.03));
    CHECK(notes[0].partials_s == Approx(wrong_s).epsilon(0).margin(0.05));
    CHECK(notes[0].other_partial == 2);
    CHECK(notes[0].right() == (wrong_s <= 0.25));
    CHECK(describe(notes[0]).find(", on partial 2 for 0.") != std::string::npos);
  }
}

TEST_CASE("pitch track: a note speaks when the study of playability says that it stands", "[analysis]") {
  auto samples = sung(steps({110}, 3.0));
  // 26 dB below what it ends as until 0.4 s: in tune, and not there yet.
  for (std::size_t n = 0; n < 19200; ++n) samples[n] *= 0.05;
  const auto notes = detected_of(samples, steps({110}, 3.0));
  REQUIRE(notes.size() == 1);
  REQUIRE(notes[0].speaks_after_s);
  CHECK(*notes[0].speaks_after_s == Approx(0.4).epsilon(0).margin(0.03));
  SceneRecording recording;
  recording.sample_rate = kRate;
  recording.signals = {{"instrument.sound", {}, samples}};
  recording.roles = {{"monitor", "instrument.sound", {}}};
  Playability playability;
  playability.kind = Playability::Kind::Tone;
  playability.sound.name = "instrument.sound";
  playability.pitch_hz = 110;
  playability.to_s = 2.5;
  CHECK(reading(evaluate(recording, playability), playability.kind, "start_s") == *notes[0].speaks_after_s);
}

TEST_CASE("pitch track: a vibrato is one note, and reported as one", "[analysis]") {
  const auto expected = vibrato(220, 20, 2.0);
  const auto notes = detected(expected, expected);
  REQUIRE(notes.size() == 1);
  CHECK_FALSE(notes[0].expected.glides);
  // From crest to crest, of which one in twenty moments is one; the tracked pitch is a little smoothed by the
  // windows.
  CHECK(notes[0].expected_swing_cents == Approx(40).epsilon(0).margin(0.1));
  CHECK(notes[0].swing_cents == Approx(38).epsilon(0).margin(2.5));
  REQUIRE(notes[0].vibrato_hz);
  CHECK(*notes[0].vibrato_hz == Approx(5).epsilon(0).margin(0.15));
  CHECK(describe(notes[0]).find("(40 expected)") != std::string::npos);
}

TEST_CASE("pitch track: a slide is a glide between two notes", "[analysis]") {
  const double fifth = 110 * std::exp2(7.0 / 12);
  const auto expected = slide(110, fifth, 0.8);
  const auto notes = detected(expected, expected);
  REQUIRE(notes.size() == 3);
  CHECK_FALSE(notes[0].expected.glides);
  REQUIRE(notes[1].expected.glides);
  CHECK_FALSE(notes[2].expected.glides);
  CHECK(notes[1].expected.from_s == Approx(0.5).epsilon(0).margin(kPitchHop_s));
  CHECK(notes[1].expected.seconds() == Approx(0.8).epsilon(0).margin(2 * kPitchHop_s));
  CHECK(notes[1].right());
  CHECK(notes[1].cents == Approx(0).margin(1));
  CHECK(describe(notes[1]).starts_with("from A2 to E3 in 0.8"));
  CHECK(describe(notes).starts_with("2 of 2 notes right and 1 of 1 glides, "));
  // Whoever stays where he was has not played it.
  const auto lazy = detected(steps({110}, 1.8), expected);
  CHECK_FALSE(lazy[1].right());
  CHECK(lazy[2].partial == 1);
  CHECK(lazy[2].cents == Approx(-700).margin(0.1));
  CHECK(describe(lazy[2]).starts_with("E3, 164.8 Hz: not right: 110.0 Hz sounds, A2, -700.0 cents"));
}

TEST_CASE("pitch track: steps off the scale are notes of their own, and compared with what is expected",
          "[analysis]") {
  const double off = 220 * std::exp2(40.0 / 1200);
  const auto expected = steps({220, off, 220}, 0.3);
  const auto notes = detected(expected, expected);
  REQUIRE(notes.size() == 3);
  CHECK(notes[1].right());
  CHECK(notes[1].cents == Approx(0).margin(0.1));
  CHECK(describe(notes[1]).starts_with("A3 +40 cents, 225.1 Hz: "));
  const auto tempered = detected(steps({220}, 0.9), expected);
  CHECK(tempered[1].cents == Approx(-40).margin(0.1));
  CHECK_FALSE(tempered[1].right());
}
