#include <catch2/catch.hpp>

#include "engine/nodes/table.h"
#include "engine/study/stability/stability.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;

TEST_CASE("stability: a spring in a part with a rate of its own is late by its delay, its hold and the world",
          "[analysis]") {
  const test::TemporaryFolder folder;
  folder.write("spring.toml", R"(
format = 1
[inputs]
place = { unit = "m" }
[nodes]
pull = { type = "spring", in = "place", stiffness = 1 }
late = { type = "delay", in = "pull", time = "1 / system.rate", interpolation = "none" }
[outputs]
force = { from = "late", unit = "N" }
)");
  const auto words = GENERATE(as<std::string>{}, "rate = \"1/16\"", "rate = \"1/16\", take = \"mean\"",
                              "rate = \"1/16\", between = \"line\"", "rate = \"1/4\"");
  const double ratio = words.find("1/4") == words.npos ? 16 : 4, frame = 1.0 / 48000;
  const double half = 0.5 * (ratio - 1) * frame;
  const double taken = words.find("mean") == words.npos ? 0 : half;
  const double given = words.find("line") == words.npos ? half : ratio * frame;
  const double late = 0.001 + taken + ratio * frame + given + 0.5 * frame;
  const auto graph = parse_graph_leniently(
      "format = 1\n[inputs]\nplace = { unit = \"m\" }\n[nodes]\n"
      "felt = { use = \"spring.toml\", place = \"place\", " +
          words + " }\n[outputs]\npush = { from = \"felt\", unit = \"N\" }\n",
      (folder.path() / "test.toml").string());
  StabilityOptions options;
  options.world.delay = 1_ms;
  options.world.device = {0.05, 0.1};
  const auto verdict = analyse_stability({nullptr, &graph, &standard_nodes()}, options);
  REQUIRE(verdict);
  for (const auto& regime : verdict->regimes) {
    if (regime.name != "at rest" || regime.held) continue;
    REQUIRE(regime.stiff.size() == 1);
    CHECK(regime.stiff[0].stable_up_to == Approx(0.1 / late).epsilon(0.01));
  }
}
