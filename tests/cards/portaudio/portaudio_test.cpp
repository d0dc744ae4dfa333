#include <catch2/catch.hpp>

#include "tests/cards/ways.h"
#include "tests/support/noise_probe.h"
#include "tests/support/wait_until.h"

using namespace tactus;

TEST_CASE("portaudio: with the server's own blocks the round trip is one of them shorter", "[cards]") {
  const auto rig = test::start_card();
  auto request = rig->request({"portaudio:jack", nullptr}, 1, 1);
  request.block_frames.reset();
  test::GuardedProbe probe{1, 4800};
  const auto portaudio = test::backend_named("portaudio");
  const auto stream = portaudio->open(request, probe.guarded);
  REQUIRE(stream);
  probe.guarded.skip_soft_start();
  CHECK((*stream)->granted().block_frames == 0);
  REQUIRE((*stream)->start());
  REQUIRE(test::wait_until([&] { return probe.probe.full(); }));
  REQUIRE((*stream)->stop());
  CHECK((*stream)->health().longest_block == 256);
  CHECK(probe.probe.delay(0, 0) == 960 + 256);
}

TEST_CASE("portaudio: a latency below zero is none, and not a day", "[cards]") {
  const auto server = test::start_sound_server();
  const test::DelayClient card;  // it says that it has none, and PortAudio subtracts a block
  const auto portaudio = test::backend_named("portaudio");
  test::GuardedProbe probe{1};
  StreamRequest request;
  request.in_channels = request.out_channels = 1;
  request.device = "portaudio:jack:" + card.name();
  const auto stream = portaudio->open(request, probe.guarded);
  REQUIRE(stream);
  CHECK((*stream)->granted().input_latency_frames == std::nullopt);
  CHECK((*stream)->granted().output_latency_frames == std::nullopt);
}
