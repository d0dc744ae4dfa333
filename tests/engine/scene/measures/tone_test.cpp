#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "engine/scene/measures/playability_result.h"
#include "tests/support/reading.h"

using namespace tactus;
using tactus::test::reading;

namespace {

constexpr double kRate = 48000, kPitch_hz = 110;
constexpr auto kTone = Playability::Kind::Tone;

/// Three partials of a pitch; `level` over time.
PlayabilityResult result_of(
    double hertz, const std::function<double(double)>& level,
    const std::function<double(double)>& added = [](double) { return 0.0; }) {
  SceneRecording recording;
  recording.sample_rate = Hertz{kRate};
  recording.signals = {{"instrument.sound", Dimension{}, {}}};
  for (int n = 0; n < 3 * static_cast<int>(kRate); ++n) {
    const double time = n / kRate, turn = 2 * std::numbers::pi * hertz * time;
    recording.signals[0].samples.push_back(
        added(time) + level(time) * (std::sin(turn) + 0.5 * std::sin(2 * turn) + 0.25 * std::sin(3 * turn)));
  }
  Playability playability;
  playability.kind = kTone;
  playability.pitch_hz = kPitch_hz;
  playability.to_s = 2.5;
  playability.sound.name = "instrument.sound";
  return evaluate(recording, playability);
}
PlayabilityResult result_of(double hertz, double level = 0.1) {
  return result_of(hertz, [=](double) { return level; });
}

/// Notes of a second each from 0 s on; what sounds of each is `factor` times as high and begins `late`.
struct Note {
  double expected_hz, factor = 1, late_s = 0, louder = 1;
};
PlayabilityResult result_of_notes(const std::vector<Note>& notes, double rocking_cents = 0) {
  SceneRecording recording;
  recording.sample_rate = Hertz{kRate};
  recording.signals = {{"instrument.sound", Dimension{}, {}}, {"wanted.pitch", Dimension{.second = -1}, {}}};
  double turn = 0;
  for (std::size_t i = 0; i < notes.size(); ++i)
    for (int n = 0; n < static_cast<int>(kRate); ++n) {
      const double time = n / kRate, rocks = rocking_cents * std::sin(2 * std::numbers::pi * 5 * time);
      const double hertz = notes[i].expected_hz * std::exp2(rocks / 1200);
      turn += 2 * std::numbers::pi * hertz * notes[i].factor / kRate;
      recording.signals[0].samples.push_back(time < notes[i].late_s ? 0
                                                                    : 0.1 * notes[i].louder * std::sin(turn));
      recording.signals[1].samples.push_back(hertz);
    }
  Playability playability;
  playability.kind = kTone;
  playability.pitch.name = "wanted.pitch";
  playability.from_s = 0.4;
  playability.sound.name = "instrument.sound";
  return evaluate(recording, playability);
}

}  // namespace

TEST_CASE("tone: the note wanted, steady from the start, has the score 1", "[analysis]") {
  const auto run = result_of(kPitch_hz);
  CHECK(run.kind == "right note");
  CHECK(run.score == Approx(1).margin(0.005));  // it stands after 30 ms
  CHECK(run.playable);
  CHECK(reading(run, kTone, "cents") == Approx(0).margin(0.2));
  CHECK(reading(run, kTone, "partial") == 1);
  // 0.1 sqrt((1 + 0.25 + 0.0625) / 2)
  CHECK(reading(run, kTone, "rms") == Approx(0.1 * std::sqrt(1.3125 / 2)).epsilon(0.01));
}

TEST_CASE("tone: another partial, a stray pitch, silence", "[analysis]") {
  CHECK(result_of(3 * kPitch_hz).kind == "wrong partial");
  CHECK(reading(result_of(3 * kPitch_hz), kTone, "partial") == 3);
  CHECK(result_of(1.4 * kPitch_hz).kind == "howl");
  CHECK(result_of(kPitch_hz, 1e-5).kind == "silent");
  for (const auto& run : {result_of(3 * kPitch_hz), result_of(1.4 * kPitch_hz), result_of(kPitch_hz, 1e-5)}) {
    CHECK_FALSE(run.playable);
    CHECK(run.score == 0);
  }
}

TEST_CASE("tone: in tune means within 25 cents", "[analysis]") {
  const auto off = [](double cents) { return result_of(kPitch_hz * std::exp2(cents / 1200)); };
  CHECK(off(23).playable);
  CHECK_FALSE(off(27).playable);
  CHECK(reading(off(23), kTone, "cents") == Approx(23).margin(0.2));
}

// It stands from 0.5 s on.
TEST_CASE("tone: a tone that speaks late has half the score after half a second", "[analysis]") {
  const auto run = result_of(kPitch_hz, [](double time) { return time < 0.5 ? 0.0 : 0.1; });
  CHECK(run.kind == "right note");
  CHECK(reading(run, kTone, "start_s") == Approx(0.5).margin(0.04));
  CHECK(run.score == Approx(near(reading(run, kTone, "start_s"), kHalfStart_s)).epsilon(1e-3));
  CHECK(run.score == Approx(0.5).margin(0.05));
}

TEST_CASE("tone: of several notes the score is the mean, and the weakest says what it was", "[analysis]") {
  const auto all = result_of_notes({{110}, {165}, {220}, {110}});
  CHECK(all.playable);
  CHECK(all.score == Approx(1).margin(0.005));
  CHECK(reading(all, kTone, "notes") == 4);
  CHECK(reading(all, kTone, "good") == 4);
  // One note an octave too high counts for nothing, and spoils the phrase.
  const auto octave = result_of_notes({{110}, {165, 2}, {220}, {110}});
  CHECK(octave.kind == "wrong partial");
  CHECK(octave.score == Approx(0.75).epsilon(0.01));
  CHECK_FALSE(octave.playable);
  CHECK(reading(octave, kTone, "partial") == 2);
  CHECK(reading(octave, kTone, "good") == 3);
  const auto late = result_of_notes({{110}, {165, 1, 0.4}, {220}, {110}});
  CHECK(late.kind == "right note");
  CHECK(late.playable);
  CHECK(reading(late, kTone, "start_s") == Approx(0.4).margin(0.04));
  CHECK(late.score == Approx((3 + near(reading(late, kTone, "start_s"), kHalfStart_s)) / 4).margin(0.03));
}

// 40 cents: a note that is scored by its mean would be wrong for half of the time.
TEST_CASE("tone: a vibrato that the scene asks for is right", "[analysis]") {
  const auto run = result_of_notes({{220}, {220}}, 40);
  CHECK(reading(run, kTone, "notes") == 1);  // no step in between
  CHECK(run.kind == "right note");
  CHECK(reading(run, kTone, "swing_cents") > 60);
}

TEST_CASE("tone: a level that grows evenly is steady", "[analysis]") {
  const auto run = result_of(kPitch_hz, [](double time) { return 0.05 * (1 + time); });
  CHECK(reading(run, kTone, "level_spread") < 0.01);
  CHECK(run.score == Approx(1).margin(0.005));  // it stands after 30 ms
}

// A swing of the level by m has a standard deviation of m / sqrt(2) of its mean. Of the three swings that are
// result_of the straight line through them takes 12 / (2 pi 3)^2 off the square.
TEST_CASE("tone: a level that swings loses by its spread", "[analysis]") {
  const auto run = result_of(
      kPitch_hz, [](double time) { return 0.1 * (1 + 0.7 * std::sin(2 * std::numbers::pi * 2 * time)); });
  CHECK(reading(run, kTone, "level_spread") ==
        Approx(0.7 * std::sqrt(0.5 - 12 / std::pow(6 * std::numbers::pi, 2))).epsilon(0.05));
  CHECK(run.score == Approx(near(reading(run, kTone, "level_spread"), kHalfUnsteady)).epsilon(0.05));
}

// Noise of uniform distribution and level a has a third of a^2; of the difference of two it is twice as much,
// of which the measure takes half. The tone has 0.1^2 1.3125 / 2.
TEST_CASE("tone: noise in the first 0.3 s counts by its energy", "[analysis]") {
  std::mt19937 random{1};
  std::uniform_real_distribution<double> noise{-1, 1};
  const auto with = [&](double level) {
    return result_of(
        kPitch_hz, [](double) { return 0.1; },
        [&](double time) { return time < 0.3 ? level * noise(random) : 0.0; });
  };
  CHECK(reading(with(0), kTone, "onset_noise") < 1e-3);
  const double level = 0.05, share = level * level / 3 / (0.01 * 1.3125 / 2 + level * level / 3);
  const auto run = with(level);
  CHECK(reading(run, kTone, "onset_noise") == Approx(share).epsilon(0.05));
  CHECK(run.score < with(0).score);
}

TEST_CASE("tone: notes of different levels lose by how far apart they are", "[analysis]") {
  const auto even = result_of_notes({{110}, {165}, {220}, {110}});
  const auto uneven = result_of_notes({{110, 1, 0, 2}, {165}, {220, 1, 0, 2}, {110}});
  // Two at 0 and two at 6 dB.
  CHECK(reading(uneven, kTone, "note_levels_db") == Approx(3.01).margin(0.02));
  CHECK(uneven.score == Approx(even.score * near(3.01, kHalfLevel_db)).epsilon(0.01));
}
