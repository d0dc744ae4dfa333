#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/mostly_idle_graph.h"
#include "tests/support/graphs/node_runner.h"

using namespace tactus;

TEST_CASE("compile: 10000 nodes of which 12 matter become the steps and the memory of the 12", "[graph]") {
  const auto alone = test::engine_of(test::twelve_alone());
  const auto among = test::engine_of(test::twelve_among(10'000));
  const auto &few = alone->plan(), &many = among->plan();
  CHECK(many.steps.size() == few.steps.size());
  CHECK(many.operations.size() == few.operations.size());
  CHECK(many.nodes.size() == few.nodes.size());
  CHECK(many.arena.size() == few.arena.size());
  CHECK(many.sections.size() == few.sections.size());
  const auto x = test::noise(5000, 1);
  CHECK(test::run(*among, {x}, 5000, {64}) == test::run(*alone, {x}, 5000, {64}));
}

TEST_CASE("compile: each of the 9988 nodes that do not run is named, with the reason", "[graph]") {
  const auto engine = test::engine_of(test::twelve_among(10'000));
  std::set<std::string> named;
  std::map<std::string, int> reasons;
  for (const auto& left : engine->plan().left_out) {
    named.insert(left.path);
    ++reasons[left.reason.starts_with("is always") ? "is always" : left.reason];
  }
  const auto idle =
      std::count_if(named.begin(), named.end(), [](const auto& name) { return name.starts_with("idle"); });
  CHECK(idle == 9988);
  CHECK(reasons["is always"] == 1998);
  CHECK(reasons["reaches only signals that are multiplied by zero"] == 400);
  CHECK(reasons["its output is not used"] == 1997);
}
