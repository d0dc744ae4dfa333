#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>

#include "latency/measurement.h"
#include "tests/cards/alsa/cable_card.h"
#include "tests/cards/watched_stream.h"
#include "tests/support/wait_until.h"

// Real drivers of a real kernel, in a virtual machine that is three to ten times slower than this one: what
// is asked is what comes, not when it comes.

using namespace tactus;
using std::chrono::seconds;
using test::alsa_ways;
using test::CableCard;
using test::GuardedProbe;
using test::wait_until;

namespace {

constexpr std::chrono::milliseconds kPatience = seconds{120};

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

int times(const char* variable, int usual) {
  const char* text = std::getenv(variable);
  return text == nullptr ? usual : std::atoi(text);
}

test::WatchedStream play(const test::Way& way, const CableCard& card) {
  auto backend = way.backend();
  const auto request = card.request(*backend, 48000, 2048);
  return {std::move(backend), request, 48000, kPatience};
}

/// One run; nothing where the slow machine lost frames, which must then be the verdict.
std::optional<Measurement> measured(Backend& backend, const StreamRequest& request) {
  MeasureSettings settings;
  settings.request = request;
  settings.guard = {DriveGuard::Kind::Audio, {}};
  settings.openings = 1;
  settings.probes = 3;
  auto measurement = measure(backend, settings);
  if (!measurement) FAIL(to_string(measurement.error()));
  const auto& health = measurement->openings.front().health;
  if (health.xruns + health.lost_frames == 0) return std::move(*measurement);
  CHECK(code(measurement->finding.verdict) == std::string{"LOST_FRAMES"});
  return std::nullopt;
}

}  // namespace

TEST_CASE("alsa: the cards and their two sides are listed under names that tell them apart", "[.alsa]") {
  const CableCard first{1}, second{2};
  for (const auto& way : alsa_ways()) {
    CAPTURE(way.name);
    const auto backend = way.backend();
    for (const auto* card : {&first, &second}) {
      CHECK(card->output_of(*backend));
      CHECK(card->input_of(*backend));
    }
  }
}

TEST_CASE("alsa: what is measured is the whole number of frames that a correlation finds", "[.alsa]") {
  const CableCard card;
  for (const auto& way : alsa_ways())
    for (const double rate : {44100.0, 48000.0, 96000.0})
      for (const int block : {1024, 2048, 4096}) {
        CAPTURE(way.name, rate, block);
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
                      << opening.granted.periods << ": " << measurement->delay_frames
                      << " frames, correlation " << whole);
      }
}

TEST_CASE("alsa: a card that is pulled out while it plays is lost, and plays again when it is back",
          "[.alsa]") {
  const CableCard card;
  for (const auto& way : alsa_ways()) {
    CAPTURE(way.name);
    auto player = play(way, card);
    for (int turn = 1; turn <= times("TACTUS_PULLS", 3); ++turn) {
      CAPTURE(turn);
      card.pull();
      REQUIRE(player.until(StreamState::Lost));
      card.plug();
      REQUIRE(player.until([&] { return player.stream->returns() == turn; }));
      REQUIRE(player.plays_on());
    }
    CHECK(player.stream->stop());
  }
}

TEST_CASE("alsa: while a card is away, its equal is never opened in its place", "[.alsa]") {
  const CableCard card{1}, equal{2};
  for (const auto& way : alsa_ways()) {
    CAPTURE(way.name);
    auto player = play(way, card);
    card.pull();
    REQUIRE(player.until(StreamState::Lost));
    const auto since = std::chrono::steady_clock::now();
    CHECK_FALSE(wait_until([&] { return player.stream->tick(), player.stream->returns() > 0; },
                           std::chrono::milliseconds{20 * ReconnectingStream::kRetry.count()}));
    CHECK(std::chrono::steady_clock::now() - since >= 20 * ReconnectingStream::kRetry);
    card.plug();
    REQUIRE(player.until([&] { return player.stream->returns() == 1; }));
    CHECK(player.stream->granted().device.find(card.name()) != std::string::npos);
  }
}

TEST_CASE("alsa: a card that another program has is refused with its name, and opens when it is free",
          "[.alsa]") {
  const CableCard card;
  for (const auto& way : alsa_ways()) {
    CAPTURE(way.name);
    auto other = play(way, card);
    const auto backend = way.backend();
    GuardedProbe probe{1};
    auto request = card.request(*other.backend, 48000, 2048);
    const auto refused = backend->open(request, probe.guarded);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == Errc::Device);
    CHECK(to_string(refused.error()).find(card.name()) != std::string::npos);
    CHECK(other.stream->stop());
    other.stream.reset();
    CHECK(backend->open(request, probe.guarded));
  }
}
