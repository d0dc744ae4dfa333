#include "apps/cli/backends.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "apps/cli/console.h"
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

TEST_CASE("app backends: the id in a rig is compared exactly", "[apps]") {
  CHECK(choose_devices("loop", "loop:echo", "", DeviceNames::Partial)->output.id == "loop:echo_cancel");
  const auto part = choose_devices("loop", "loop:echo", "", DeviceNames::Exact);
  REQUIRE_FALSE(part);
  CHECK(test::summary(part).find("'loop:echo'") != std::string::npos);
  CHECK(choose_devices("loop", "loop:echo_cancel", "", DeviceNames::Exact)->output.id == "loop:echo_cancel");
  Rig::Device rig;
  rig.output = "loop:cable";
  DeviceOptions options;
  CHECK(choose_devices(options, rig).output.id == "loop:cable");
  options.backend = "loop";
  try {
    (void)choose_devices(options, rig);
    FAIL("a rig names the device with its backend");
  } catch (const CommandError& error) {
    CHECK(error.errors.front().where == "--backend");
  }
}
