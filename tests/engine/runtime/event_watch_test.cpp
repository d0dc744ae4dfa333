#include "engine/runtime/event_watch.h"

#include <catch2/catch.hpp>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"
#include "tests/support/graphs/part_graph.h"

using namespace tactus;
using test::Samples;

namespace {

/// `late` has the triggers of x, 10 frames later, with the value of `level` then as how strong they were.
const std::string kGraph = R"([inputs]
x = {}
level = {}
[nodes]
late  = { type = "event_delay", trigger = "x", time = "10 / system.rate", value = "level" }
slow  = { use = "part.toml", x = "x", rate = "1/3" }
[outputs]
y = { from = "late + late.value + slow" }
)";
const std::string kPart =
    "[inputs]\nx = {}\n[nodes]\ninside = { type = \"event_delay\", trigger = \"x\", time = \"0 s\" }\n"
    "[outputs]\ny = { from = \"inside\" }\n";

std::vector<WatchedEvent> collect(EventWatch& watch) {
  std::vector<WatchedEvent> all;
  for (WatchedEvent event; watch.take(event);) all.push_back(event);
  return all;
}

}  // namespace

TEST_CASE("event watch: finds each event in its frame with its level, whatever the blocks are") {
  const std::vector<int> blocks = GENERATE(std::vector{64}, std::vector{1}, std::vector{1000, 3, 77});
  const test::PartGraphs graphs{kPart};
  const auto player = graphs.engine(kGraph);
  const auto events = graph_events(player->plan());
  REQUIRE(events.size() == 1);  // not those of parts
  CHECK(events[0].name == "late");
  EventWatch watch;
  player->add_observer(watch);
  REQUIRE(watch.choose(player->version(), events));
  Samples x(3000, 0.0), level(3000, 0.0);
  const std::vector<std::int64_t> frames = {0, 100, 1000, 1095, 1200, 2989};
  for (std::size_t e = 0; e < frames.size(); ++e) {
    x[static_cast<std::size_t>(frames[e])] = 1.0;
    level[static_cast<std::size_t>(frames[e])] = 0.25 * static_cast<double>(e + 1);
  }
  (void)test::run(*player, {x, level}, 3000, blocks);
  const auto found = collect(watch);
  REQUIRE(found.size() == 5);  // that of frame 1,095 follows in less than 2 ms, which are 96 frames
  for (std::size_t e = 0; e < found.size(); ++e) {
    const auto at = e < 3 ? e : e + 1;
    CHECK(found[e].frame == frames[at] + 10);
    CHECK(found[e].level == 0.25 * static_cast<double>(at + 1));
    CHECK(found[e].version == player->version());
  }
}

TEST_CASE("event watch: events of another version of the graph are not told") {
  const test::PartGraphs graphs{kPart};
  const auto player = graphs.engine(kGraph);
  EventWatch watch;
  player->add_observer(watch);
  REQUIRE(watch.choose(player->version() + 1, graph_events(player->plan())));
  Samples x(100, 0.0);
  x[5] = 1.0;
  (void)test::run(*player, {x, x}, 100, {64});
  CHECK(collect(watch).empty());
}
