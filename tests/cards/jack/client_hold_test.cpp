#include "backends/jack/client_hold.h"

#include <catch2/catch.hpp>

using tactus::jack::ClientHold;
using tactus::jack::note_server_death;

TEST_CASE("jack: after a death no client is opened until all that were open are closed", "[cards][jack]") {
  note_server_death();  // of nobody's server
  auto first = ClientHold::acquire();
  REQUIRE(first);
  CHECK_FALSE(ClientHold::acquire());  // while the first one is opened
  first->opened();
  auto second = ClientHold::acquire();
  REQUIRE(second);
  second->opened();
  note_server_death();
  CHECK_FALSE(ClientHold::acquire());
  first.reset();
  CHECK_FALSE(ClientHold::acquire());
  second.reset();
  first = ClientHold::acquire();
  REQUIRE(first);
  first->opened();
  first->closing();
  CHECK_FALSE(ClientHold::acquire());
}
