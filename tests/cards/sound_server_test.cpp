#include "tests/support/sound_server.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <set>

// The server that the other tests stand on.

using namespace tactus;

namespace {

std::set<std::string> shared_memory() {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator("/dev/shm"))
    names.insert(entry.path().filename().string());
  return names;
}

}  // namespace

TEST_CASE("sound server: is the default one while it is there, and leaves nothing", "[cards]") {
  const auto before = shared_memory();
  std::string name;
  {
    const auto server = test::start_sound_server();
    name = server->name();
    CHECK(std::string{std::getenv("JACK_DEFAULT_SERVER")} == name);
  }
  CHECK(std::getenv("JACK_DEFAULT_SERVER") == nullptr);
  for (const auto& file : shared_memory()) CHECK(file.find(name) == std::string::npos);
}

TEST_CASE("sound server: begins again under its name after it was killed, and leaves nothing then",
          "[cards]") {
  std::string name;
  {
    const auto server = test::start_sound_server();
    name = server->name();
    server->kill();
    server->restart();
    CHECK(server->name() == name);
    server->kill();
  }
  for (const auto& file : shared_memory()) CHECK(file.find(name) == std::string::npos);
}

TEST_CASE("sound server: a card can be connected, disconnected, and told to be late", "[cards]") {
  const auto server = test::start_sound_server();
  test::DelayClient card;
  const auto capture = card.name() + ":capture_1", playback = card.name() + ":playback_1";
  server->connect(capture, playback);
  CHECK(server->connections(capture) == playback + "\n");
  server->disconnect(card.name());
  CHECK(server->connections(capture).empty());
  server->set_period(512);
  const auto before = card.xruns();
  card.sleep_once(std::chrono::milliseconds{50});
  CHECK(card.xruns() == before + 1);
}
