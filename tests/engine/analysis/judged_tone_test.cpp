#include "engine/analysis/judged_tone.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>

using namespace tactus;

namespace {

constexpr double kRate = 48000, kPitch_hz = 110;
constexpr auto kTone = Playability::Kind::Tone;

/// Three partials of a pitch; `level` over time.
JudgedRun judged(double hertz, const std::function<double(double)>& level) {
  SceneRecording recording;
  recording.sample_rate = Hertz{kRate};
  recording.signals = {{"instrument.sound", Dimension{}, {}}};
  for (int n = 0; n < 3 * static_cast<int>(kRate); ++n) {
    const double time = n / kRate, turn = 2 * std::numbers::pi * hertz * time;
    recording.signals[0].samples.push_back(
        level(time) * (std::sin(turn) + 0.5 * std::sin(2 * turn) + 0.25 * std::sin(3 * turn)));
  }
  Playability playability;
  playability.kind = kTone;
  playability.pitch_hz = kPitch_hz;
  playability.to_s = 2.5;
  return judge_tone(recording, playability);
}
JudgedRun judged(double hertz, double level = 0.1) {
  return judged(hertz, [=](double) { return level; });
}

}  // namespace

TEST_CASE("judged tone: the note wanted, steady from the start, has the score 1", "[analysis]") {
  const auto run = judged(kPitch_hz);
  CHECK(run.kind == "right note");
  CHECK(run.score == Approx(1));
  CHECK(run.playable);
  CHECK(run.reading(kTone, "cents") == Approx(0).margin(0.2));
  CHECK(run.reading(kTone, "partial") == 1);
  // 0.1 sqrt((1 + 0.25 + 0.0625) / 2)
  CHECK(run.reading(kTone, "rms") == Approx(0.1 * std::sqrt(1.3125 / 2)).epsilon(0.01));
}

TEST_CASE("judged tone: another partial, a stray pitch, silence", "[analysis]") {
  CHECK(judged(3 * kPitch_hz).kind == "wrong partial");
  CHECK(judged(3 * kPitch_hz).reading(kTone, "partial") == 3);
  CHECK(judged(1.4 * kPitch_hz).kind == "howl");
  CHECK(judged(kPitch_hz, 1e-5).kind == "silent");
  for (const auto& run : {judged(3 * kPitch_hz), judged(1.4 * kPitch_hz), judged(kPitch_hz, 1e-5)}) {
    CHECK_FALSE(run.playable);
    CHECK(run.score == 0);
  }
}

TEST_CASE("judged tone: in tune means within 25 cents", "[analysis]") {
  const auto off = [](double cents) { return judged(kPitch_hz * std::exp2(cents / 1200)); };
  CHECK(off(23).playable);
  CHECK_FALSE(off(27).playable);
  CHECK(off(23).reading(kTone, "cents") == Approx(23).margin(0.2));
}

// It stands from 0.5 s on: a quarter of a second too late by half.
TEST_CASE("judged tone: a tone that speaks late has half the score after half a second", "[analysis]") {
  const auto run = judged(kPitch_hz, [](double time) { return time < 0.5 ? 0.0 : 0.1; });
  CHECK(run.kind == "right note");
  CHECK(run.reading(kTone, "start_s") == Approx(0.5).margin(0.04));
  CHECK(run.score == Approx(kPrompt_s / run.reading(kTone, "start_s")).epsilon(1e-9));
}

// A swing of the level by m has a standard deviation of m / sqrt(2) of its mean.
TEST_CASE("judged tone: a level that swings loses by its spread", "[analysis]") {
  const auto run = judged(
      kPitch_hz, [](double time) { return 0.1 * (1 + 0.7 * std::sin(2 * std::numbers::pi * 2 * time)); });
  CHECK(run.reading(kTone, "level_spread") == Approx(0.7 / std::sqrt(2.0)).epsilon(0.05));
  CHECK(
      run.score ==
      Approx(run.reading(kTone, "right") * kSteadySpread / run.reading(kTone, "level_spread")).epsilon(1e-9));
}
