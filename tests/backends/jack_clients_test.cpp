#include "backends/jack_clients.h"

#include <catch2/catch.hpp>

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
