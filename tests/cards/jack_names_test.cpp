// Libraries that take the name of a JACK client for a regular expression, on a real server.
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>

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
