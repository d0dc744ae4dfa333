// Libraries that take the name of a JACK client for a regular expression, on a real server.
#include <jack/jack.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>

#include "tests/cards/ways.h"
#include "tests/support/error_summary.h"
#include "tests/support/noise_probe.h"

using namespace tactus;
using test::DelayClient;

TEST_CASE(
    "jack names: a client whose name matches another's as a regular expression is left out, with the remedy",
    "[cards]") {
  const auto server = test::start_sound_server();
  const DelayClient other{{.name = "abc"}}, card{{.name = "a.c"}};
  for (const std::string library : {"rtaudio", "portaudio"}) {
    if (!test::has_backend(library)) continue;
    CAPTURE(library);
    const auto backend = test::backend_named(library);
    const auto devices = backend->devices();
    REQUIRE(devices);
    const auto count = [&](const DelayClient& client) {
      return std::ranges::count(*devices, library + ":jack:" + client.name(), &Device::id);
    };
    CHECK(count(other) == 1);
    CHECK(count(card) == 0);
    StreamRequest request;
    request.device = library + ":jack:" + card.name();
    request.out_channels = 1;
    request.client_name = "tactus-" + std::to_string(::getpid());
    test::GuardedProbe probe{1};
    const auto refused = backend->open(request, probe.guarded);
    REQUIRE_FALSE(refused);
    CHECK(test::summary(refused) == "UnknownName '" + request.device + "' --backend");
  }
  const auto jack = test::backend_named("jack");
  StreamRequest request;
  request.device = "jack:" + card.name();
  request.out_channels = 1;
  test::GuardedProbe probe{1};
  const auto stream = jack->open(request, probe.guarded);
  REQUIRE(stream);
  CHECK((*stream)->granted().output.ports == std::vector<std::string>{card.name() + ":playback_1"});
}

TEST_CASE("jack names: a client is left out while a port of another one would be opened in its place",
          "[cards]") {
  const auto server = test::start_sound_server();
  const auto name = "other-" + std::to_string(::getpid());
  const std::unique_ptr<jack_client_t, int (*)(jack_client_t*)> other{
      jack_client_open(name.c_str(), JackNoStartServer, nullptr), jack_client_close};
  REQUIRE(other);
  // It is registered before the card's, and called like these later.
  auto* const port = jack_port_register(other.get(), "in", JACK_DEFAULT_AUDIO_TYPE, JackPortIsInput, 0);
  REQUIRE(port);
  const DelayClient card;
  for (const std::string library : {"rtaudio", "portaudio"}) {
    if (!test::has_backend(library)) continue;
    CAPTURE(library);
    const auto backend = test::backend_named(library);
    const auto out_channels = [&] {
      const auto devices = backend->devices();
      REQUIRE(devices);
      const auto found = std::ranges::find(*devices, library + ":jack:" + card.name(), &Device::id);
      return found == devices->end() ? 0 : found->out_channels;
    };
    REQUIRE(jack_port_rename(other.get(), port, "in") == 0);
    CHECK(out_channels() == 2);
    REQUIRE(jack_port_rename(other.get(), port, (card.name() + ":in").c_str()) == 0);
    CHECK(out_channels() == 0);
    StreamRequest request;
    request.device = library + ":jack:" + card.name();
    request.out_channels = 1;
    request.client_name = "tactus-" + std::to_string(::getpid());
    test::GuardedProbe probe{1};
    const auto refused = test::summary(backend->open(request, probe.guarded));
    CHECK_THAT(refused,
               Catch::StartsWith("UnknownName '" + request.device + "'") && Catch::EndsWith(" --backend"));
  }
}
