#include <unistd.h>

#include <catch2/catch.hpp>
#include <optional>

#include "tests/cards/ways.h"
#include "tests/support/noise_probe.h"
#include "tests/support/sound_server.h"
#include "tests/support/undisturbed.h"
#include "tests/support/wait_until.h"

// JACK against a real server and a card of known delay: every sample, and its frame.

using namespace tactus;
using test::DelayClient;
using test::GuardedProbe;
using test::start_sound_server;
using test::wait_until;

namespace {

StreamRequest request_for(const std::string& client, int inputs, int outputs) {
  StreamRequest request;
  request.device = "jack:" + client;
  request.in_channels = inputs;
  request.out_channels = outputs;
  request.client_name = "tactus-" + std::to_string(::getpid());
  return request;
}

/// Plays until the probe has heard enough. What was granted.
StreamGranted play(const StreamRequest& request, GuardedProbe& probe) {
  const auto jack = test::backend_named("jack");
  auto stream = jack->open(request, probe.guarded);
  if (!stream) throw std::runtime_error{to_string(stream.error())};
  probe.guarded.skip_soft_start();
  REQUIRE((*stream)->start());
  CHECK((*stream)->state() == StreamState::Running);
  REQUIRE(wait_until([&] { return probe.probe.full(); }, std::chrono::seconds{20}));
  CHECK((*stream)->stop());
  CHECK((*stream)->state() == StreamState::Stopped);
  CHECK((*stream)->health().frames == probe.probe.frames());
  CHECK((*stream)->health().bad_input == 0);
  return (*stream)->granted();
}

/// Nothing where the server removed the client, as it does with one that is late on a busy machine.
std::optional<Health> start_and_stop(Stream& stream, GuardedProbe& probe, int times) {
  for (int turn = 0; turn < times; ++turn) {
    CAPTURE(turn);
    const auto before = probe.probe.frames();
    if (!stream.start()) return std::nullopt;
    REQUIRE(wait_until([&] { return probe.probe.frames() > before; }));
    if (!stream.stop()) return std::nullopt;
    REQUIRE(stream.state() == StreamState::Stopped);
  }
  CHECK(probe.probe.prepared == 1);
  CHECK(stream.health().frames == probe.probe.frames());
  return stream.health();
}

}  // namespace

TEST_CASE("jack: every sample comes back, the card's delay and one period later", "[cards][jack]") {
  const int period = GENERATE(256, 1024);
  const auto server = start_sound_server({.period = period});
  DelayClient card{{.delay_frames = 960, .input_latency = 37, .output_latency = 923}};
  GuardedProbe probe{2};
  const auto granted = play(request_for(card.name(), 2, 2), probe);
  CHECK(probe.probe.delay(0, 0) == 960 + period);
  CHECK(probe.probe.delay(1, 1) == 960 + period);
  CHECK(probe.probe.delay(0, 1) == std::nullopt);
  CHECK(granted.device == "jack:" + card.name());
  CHECK(granted.block_frames == period);
  CHECK(granted.input_latency_frames == 37.0);
  CHECK(granted.output_latency_frames == 923.0);
}

TEST_CASE("jack: through the server's own loop-back it is one period", "[cards][jack]") {
  const auto server = start_sound_server();
  GuardedProbe probe{1};
  play(request_for("loopback", 1, 1), probe);
  CHECK(probe.probe.delay(0, 0) == 256);
}

TEST_CASE("jack: any channels of a card, in any order", "[cards][jack]") {
  const auto server = start_sound_server();
  DelayClient card{{.channels = 6, .delay_frames = 100}};
  GuardedProbe probe{2};
  auto request = request_for(card.name(), 3, 2);
  request.out_map = {1, 4};  // the card's channels 2 and 5
  request.in_map = {4, 1, 0};
  play(request, probe);
  CHECK(probe.probe.delay(0, 1) == 100 + 256);
  CHECK(probe.probe.delay(1, 0) == 100 + 256);
  CHECK(probe.probe.heard(2) == std::vector<double>(48000, 0.0));
}

TEST_CASE("jack: one input and sixteen outputs, and the reverse", "[cards][jack]") {
  const auto server = start_sound_server({.channels = 2});
  DelayClient card{{.channels = 16, .delay_frames = 0}};
  {
    GuardedProbe probe{16, 4800};
    auto request = request_for(card.name(), 1, 16);
    request.in_map = {15};
    play(request, probe);
    CHECK(probe.probe.delay(0, 15) == 256);
  }
  GuardedProbe probe{1, 4800};
  play(request_for(card.name(), 16, 1), probe);
  CHECK(probe.probe.delay(0, 0) == 256);
  CHECK(probe.probe.heard(15) == std::vector<double>(4800, 0.0));
}

TEST_CASE("jack: inputs without outputs, and outputs without inputs", "[cards][jack]") {
  const auto server = start_sound_server();
  DelayClient card;
  GuardedProbe deaf{2, 4800}, mute{0, 4800};
  CHECK(play(request_for(card.name(), 0, 2), deaf).input_latency_frames == std::nullopt);
  const auto granted = play(request_for(card.name(), 2, 0), mute);
  CHECK(granted.device == "jack:" + card.name());
  CHECK(granted.output_latency_frames == std::nullopt);
}

TEST_CASE("jack: it listens to one device and plays to another", "[cards][jack]") {
  const auto server = start_sound_server();
  DelayClient near{{.name = "near", .delay_frames = 10}}, far{{.name = "far", .delay_frames = 500}};
  server->connect(near.name() + ":capture_1", far.name() + ":playback_2");
  GuardedProbe probe{1};
  auto request = request_for(near.name(), 1, 1);
  request.input_device = "jack:" + far.name();
  request.in_map = {1};
  const auto granted = play(request, probe);
  CHECK(probe.probe.delay(0, 0) == 10 + 500 + 256);
  CHECK(granted.device == "jack:" + near.name());
  CHECK(granted.input_device == "jack:" + far.name());
}

TEST_CASE("jack: runs at every rate of the server from 8 kHz to 192 kHz", "[cards][jack]") {
  const int rate = GENERATE(8000, 22050, 44100, 96000, 192000);
  const auto server = start_sound_server({.rate = rate});
  DelayClient card{{.delay_frames = 64}};
  GuardedProbe probe{1, rate / 8};
  auto request = request_for(card.name(), 1, 1);
  request.sample_rate = Hertz{static_cast<double>(rate)};
  CHECK(play(request, probe).format.sample_rate == *request.sample_rate);
  CHECK(probe.probe.delay(0, 0) == 64 + 256);
  request.sample_rate = 48_kHz;
  const auto other = test::backend_named("jack")->open(request, probe.guarded);
  REQUIRE_FALSE(other);
  CHECK(to_string(other.error()).find("it runs at " + std::to_string(rate) + " Hz") != std::string::npos);
}

TEST_CASE("jack: runs with every block of the server from 16 to 4096 frames", "[cards][jack]") {
  const int period = GENERATE(16, 32, 64, 128, 512, 2048, 4096);
  const auto server = start_sound_server({.period = period});
  DelayClient card{{.delay_frames = 64}};
  GuardedProbe probe{1, 16384};
  CHECK(play(request_for(card.name(), 1, 1), probe).block_frames == period);
  if (period >= 256) CHECK(probe.probe.delay(0, 0) == 64 + period);  // a virtual machine loses shorter ones
}

TEST_CASE("jack: starts and stops a hundred times", "[cards][jack][slow]") {
  const auto health = test::undisturbed("a client that stays with the server", [] {
    const auto server = start_sound_server({.period = 64});
    DelayClient card;
    GuardedProbe probe{2, 64};
    auto stream = test::backend_named("jack")->open(request_for(card.name(), 2, 2), probe.guarded);
    REQUIRE(stream);
    return start_and_stop(**stream, probe, 100);
  });
  CHECK(health.gaps[static_cast<std::size_t>(Gap::Unsaid)] == 0);
}

TEST_CASE("jack: a device is opened and closed again and again", "[cards][jack][slow]") {
  const auto server = start_sound_server({.period = 64});
  DelayClient card;
  GuardedProbe probe{2, 64};
  const auto jack = test::backend_named("jack");
  for (int turn = 0; turn < 20; ++turn) {
    CAPTURE(turn);
    auto stream = jack->open(request_for(card.name(), 2, 2), probe.guarded);
    REQUIRE(stream);
    // Closed while it runs, and before it ever ran.
    if (turn % 2 == 0)
      if (const auto started = (*stream)->start(); !started) FAIL(to_string(started.error()));
  }
  CHECK(probe.probe.prepared == 20);
}
