#include <catch2/catch.hpp>
#include <cmath>

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
using test::kSlowMachine;
using test::wait_until;

namespace {

test::WatchedStream play(const test::Way& way, const CableCard& card) {
  auto backend = way.backend();
  const auto request = card.request(*backend, 48000, 2048);
  return {std::move(backend), request, 48000, kSlowMachine};
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
    CHECK(player.stream->granted().output.hardware.starts_with(card.hardware()));
  }
}

TEST_CASE("alsa: a card that another program has is refused with that program, and opens when it is free",
          "[.alsa]") {
  const CableCard card;
  for (const auto& way : alsa_ways()) {
    CAPTURE(way.name);
    const auto backend = way.backend();
    GuardedProbe probe{1};
    const auto request = card.request(*backend, 48000, 2048);
    {
      auto other = test::OtherProgram::plays(card, 0, "/dev/zero");
      const auto refused = backend->open(request, probe.guarded);
      REQUIRE_FALSE(refused);
      const auto message = to_string(refused.error());
      CHECK_THAT(message, Catch::Contains(request.device));
      CHECK_THAT(message, Catch::Contains("in use by aplay"));
      // Its inputs, too: then the libraries do not list it.
      auto third = test::OtherProgram::records(card, 0, "/dev/null");
      const auto missing = backend->open(request, probe.guarded);
      REQUIRE_FALSE(missing);
      CHECK_THAT(to_string(missing.error()), Catch::Contains("in use by aplay"));
    }
    CHECK(backend->open(request, probe.guarded));
  }
}

TEST_CASE("alsa: after each xrun the frames that are counted are those of the clock", "[.alsa]") {
  constexpr int kBlock = 2048;
  const CableCard card;
  for (const auto& way : alsa_ways()) {
    CAPTURE(way.name);
    auto player = play(way, card);
    for (int turn = 1; turn <= 5; ++turn) {
      CAPTURE(turn);
      const auto before = player.stream->health();
      player.probe.probe.sleep_ms = 400;  // the buffer lasts for 85 ms
      REQUIRE(player.until([&] { return player.stream->health().xruns > before.xruns; }));
      // A block may come late, never early: the earliest one shows the count.
      const auto ahead = [&] {
        const auto health = player.stream->health();
        return static_cast<double>(health.frames + health.lost_frames) - 48000 * health.seconds;
      };
      CHECK(player.until([&] { return std::abs(ahead()) <= 2 * kBlock; }));
      CAPTURE(ahead());
    }
    CHECK(player.stream->stop());
  }
}
