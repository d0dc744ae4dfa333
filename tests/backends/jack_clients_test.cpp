#include "backends/jack_clients.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

using namespace tactus;

TEST_CASE("jack clients: after a death nothing is opened until all that was open is closed", "[backends]") {
  note_jack_server_death();  // of nobody's server
  auto first = JackClientHold::acquire();
  REQUIRE(first);
  CHECK_FALSE(JackClientHold::acquire());  // while the first one is opened
  first->opened();
  auto second = JackClientHold::acquire();
  REQUIRE(second);
  second->opened();
  CHECK_FALSE(jack_clients_must_close());
  note_jack_server_death();
  CHECK(jack_clients_must_close());
  CHECK_FALSE(JackClientHold::acquire());
  first.reset();
  CHECK_FALSE(JackClientHold::acquire());
  second.reset();
  CHECK_FALSE(jack_clients_must_close());
  first = JackClientHold::acquire();
  REQUIRE(first);
  first->opened();
  first->closing();
  CHECK_FALSE(JackClientHold::acquire());
}

TEST_CASE("jack clients: one that closes waits until no other one is opened", "[backends]") {
  auto open = JackClientHold::acquire();
  REQUIRE(open);
  open->opened();
  auto opening = JackClientHold::acquire();
  REQUIRE(opening);
  std::atomic<bool> begun{false}, opened{false};
  bool closed_after = false;
  std::thread closer{[&] {
    begun = true;
    open->closing();
    closed_after = opened;
    open.reset();
  }};
  while (!begun) std::this_thread::yield();
  for (int turn = 0; turn < 1000; ++turn) std::this_thread::yield();  // it could close now
  opened = true;
  opening->opened();
  closer.join();
  CHECK(closed_after);
}
