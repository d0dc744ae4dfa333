#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/cards/ways.h"

using namespace tactus;

namespace {

std::optional<Device> listed(const std::string& client) {
  const auto devices = test::backend_named("rtaudio")->devices();
  REQUIRE(devices);
  const auto found = std::find_if(devices->begin(), devices->end(), [&](const Device& device) {
    return device.id == "rtaudio:jack:" + client;
  });
  return found == devices->end() ? std::nullopt : std::optional{*found};
}

}  // namespace

TEST_CASE("rtaudio: a JACK client is never taken for another whose name has its own in it", "[cards]") {
  const auto server = test::start_sound_server();
  {
    const test::DelayClient card{{.name = "card", .channels = 2}}, other{{.name = "my-card", .channels = 3}};
    REQUIRE(listed(card.name()));
    CHECK(listed(card.name())->in_channels == 2);
    CHECK(listed(card.name())->out_channels == 2);
    CHECK(listed(other.name())->in_channels == 3);
  }
  const test::DelayClient other{{.name = "my-card", .channels = 3}}, card{{.name = "card", .channels = 2}};
  CHECK_FALSE(listed(card.name()));  // RtAudio would open the other's ports
  CHECK(listed(other.name())->out_channels == 3);
}
