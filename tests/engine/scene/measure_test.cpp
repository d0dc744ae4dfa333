#include "engine/scene/measure.h"

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

TEST_CASE("measure: the pitch of a part of a signal, 0 where it has none", "[scene]") {
  const auto recording = sung();
  // 0.1 cent.
  CHECK(pitch(recording, 0.1, 0.4) == Approx(220).epsilon(6e-5));
  CHECK(pitch(recording, 0.6, 0.9) == 0);
}
