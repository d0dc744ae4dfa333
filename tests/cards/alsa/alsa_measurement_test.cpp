#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <fstream>

#include "latency/measurement.h"
#include "tests/cards/alsa/cable_card.h"
#include "tests/cards/ways.h"
#include "tests/support/wait_until.h"

// The delay of a real card's cable, which is a whole number of frames.

using namespace tactus;
using test::alsa_ways;
using test::CableCard;
using test::kSlowMachine;
using test::wait_until;

namespace {

/// The whole number of frames by which the capture follows what was played, by a plain correlation at every
/// lag:
///   argmax over d of |sum over n of played[n] captured[n + d]|
/// over the loudest second of the recording.
int correlated_delay(const LoopRecording& recording, int channel, int most) {
  const auto& played = recording.played;
  const auto& captured = recording.captured[index(channel)];
  const auto length = static_cast<std::int64_t>(recording.sample_rate.value);
  std::int64_t from = 0;
  double loudest = -1.0;
  for (std::int64_t begin = 0; begin + length + most < std::ssize(played); begin += length / 2) {
    const auto piece = part_of(played, begin, begin + length);
    if (const double energy = product(piece, piece); energy > loudest) loudest = energy, from = begin;
  }
  const auto piece = part_of(played, from, from + length);
  int best = 0;
  double highest = -1.0;
  for (int lag = 0; lag <= most; ++lag) {
    const double sum = std::abs(product(piece, part_of(captured, from + lag, from + lag + length)));
    if (sum > highest) highest = sum, best = lag;
  }
  return best;
}

/// One run; nothing where the slow machine lost frames in it.
std::optional<Measurement> measured(Backend& backend, const StreamRequest& request) {
  auto measurement = measure(backend, test::short_measurement(request));
  if (!measurement) FAIL(to_string(measurement.error()));
  if (measurement->finding.verdict == Verdict::LostFrames) return std::nullopt;
  return std::move(*measurement);
}

}  // namespace

TEST_CASE("alsa: what is measured is the whole number of frames that a correlation finds", "[.alsa]") {
  const CableCard card;
  for (const auto& way : alsa_ways())
    for (const double rate : {44100.0, 48000.0, 96000.0})
      for (const int block : {1024, 2048, 4096})
        DYNAMIC_SECTION(way.name << " " << rate << " Hz, " << block) {
          const auto backend = way.backend();
          std::optional<Measurement> measurement;
          for (int turn = 0; turn < 10 && !measurement; ++turn)
            measurement = measured(*backend, card.request(*backend, rate, block));
          REQUIRE(measurement);
          const auto& opening = measurement->openings.front();
          CAPTURE(measurement->finding.what, opening.granted.block_frames, opening.granted.periods);
          CHECK(code(measurement->finding.verdict) == std::string{"ok"});
          const int whole = correlated_delay(opening.recording, 0, 8 * block);
          CHECK_THAT(measurement->delay_frames, Catch::WithinAbs(whole, 0.001));
          WARN(way.name << ", " << rate << " Hz, block " << opening.granted.block_frames << ", periods "
                        << opening.granted.periods << ", asked for " << block << ": "
                        << measurement->delay_frames << " frames, correlation " << whole);
        }
}

TEST_CASE("alsa: a measurement that loses frames is refused as LOST_FRAMES", "[.alsa]") {
  const CableCard card;
  for (const auto& way : alsa_ways()) DYNAMIC_SECTION(way.name) {
      const auto request = card.request(*way.backend(), 48000, 2048);
      test::ChildProcess latency{{TACTUS_PROGRAM, "latency", "measure", "--device", request.device,
                                  "--input-device", request.input_device, "--rate", "48 kHz", "--block",
                                  "2048", "--openings", "1", "--cable", "--json"},
                                 test::ChildProcess::Stdout::Logged};
      const auto runs = [&] {
        std::string state;
        std::getline(std::ifstream{"/proc/asound/" + card.id() + "/pcm0p/sub0/status"}, state);
        return state == "state: RUNNING";
      };
      REQUIRE(wait_until(runs, kSlowMachine));
      // Again and again until it ends: some of it is in the middle of a probe.
      while (!latency.wait(std::chrono::milliseconds{1500})) {
        latency.pause();
        CHECK_FALSE(latency.wait(std::chrono::milliseconds{400}));
        latency.send(SIGCONT);
      }
      INFO(latency.log());
      CHECK_THAT(latency.log(), Catch::Contains("LOST_FRAMES"));
    }
}
