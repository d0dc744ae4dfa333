#include "remote/keep_alive.h"

#include <catch2/catch.hpp>

using namespace tactus;
using namespace std::chrono_literals;

namespace {

constexpr KeepAlive::Clock::time_point kStart{1h};

}  // namespace

TEST_CASE("keep-alive: it expires once, 500 ms after the last refresh", "[remote]") {
  KeepAlive keep_alive;
  CHECK_FALSE(keep_alive.expired(kStart, 0));  // nobody is watched
  keep_alive.begin(kStart, 3);
  CHECK_FALSE(keep_alive.expired(kStart + 499ms, 3));
  keep_alive.refresh(kStart + 400ms, 3);
  CHECK_FALSE(keep_alive.expired(kStart + 899ms, 3));
  CHECK(keep_alive.expired(kStart + 900ms, 3));
  CHECK_FALSE(keep_alive.expired(kStart + 901ms, 3));
}

TEST_CASE("keep-alive: a refresh does not begin what has expired", "[remote]") {
  KeepAlive keep_alive;
  keep_alive.begin(kStart, 0);
  REQUIRE(keep_alive.expired(kStart + 1s, 0));
  keep_alive.refresh(kStart + 1s, 0);
  CHECK_FALSE(keep_alive.expired(kStart + 10s, 0));
}

TEST_CASE("keep-alive: drives that were disarmed and armed by somebody else are not its own", "[remote]") {
  KeepAlive keep_alive;
  keep_alive.begin(kStart, 0);
  CHECK_FALSE(keep_alive.expired(kStart + 1s, 1));
  CHECK_FALSE(keep_alive.expired(kStart + 2s, 0));
}

TEST_CASE("keep-alive: the client of an earlier arming does not refresh a later one", "[remote]") {
  KeepAlive keep_alive;
  keep_alive.begin(kStart, 0);
  keep_alive.begin(kStart + 1s, 1);
  keep_alive.refresh(kStart + 1400ms, 0);
  CHECK(keep_alive.expired(kStart + 1500ms, 1));
}
