#include "apps/cli/backends.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/core/named.h"
#include "tests/support/error_summary.h"

using namespace tactus;
using namespace tactus::app;

TEST_CASE("app backends: a simulated card is there for whoever names it, and for nobody else", "[apps]") {
  const auto cards = names_of(sound_backends());
  CHECK(std::count(cards.begin(), cards.end(), "loop") == 0);
  const auto named = backends_called("loop");
  REQUIRE(named);
  REQUIRE(named->size() == 1);
  CHECK(named->front().make()->devices()->front().id == "loop:cable");
  CHECK(backends_called("lop").error().code == Errc::UnknownName);
}

TEST_CASE("app backends: an id that says what a simulated card is makes one", "[apps]") {
  const auto chosen = choose_devices("", "loop:delay=77,gain=-6dB", "");
  REQUIRE(chosen);
  CHECK(chosen->backend->name() == "loop");
  CHECK(chosen->output.id == "loop:delay=77,gain=-6dB");
  CHECK(chosen->input.id == chosen->output.id);
  CHECK(choose_devices("loop", "", "")->output.id == "loop:cable");
  CHECK(choose_devices("loop", "echo", "")->output.id == "loop:echo_cancel");
  const auto unknown = choose_devices("", "loop:nothing", "");
  REQUIRE_FALSE(unknown);
  CHECK(test::summary(unknown).find("'loop:nothing'") != std::string::npos);
}
