#include "apps/play/live/plan.h"

#include <catch2/catch.hpp>

#include "apps/cli/console.h"

using namespace tactus;

TEST_CASE("plan: a simulated world is not recorded, which is said before any device is looked for",
          "[live]") {
  app::LiveOptions options;
  options.target = "haptic_drum";
  options.listen = true;
  options.record = "take.wav";
  options.backend = "none of this name";
  const auto error_of = [&] {
    try {
      (void)app::make_plan(options);
    } catch (const app::CommandError& error) {
      return error.errors.front();
    }
    return Error{};
  };
  CHECK(error_of().code == Errc::BadArgument);
  CHECK(error_of().where == "--record");
  CHECK(error_of().what.find("--listen") != std::string::npos);

  options.record.clear();  // what would have been reported otherwise
  CHECK(error_of().where == "--backend");
}
