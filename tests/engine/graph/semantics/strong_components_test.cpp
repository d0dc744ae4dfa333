#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/graph/plan/vertex_graph.h"

using namespace tactus;

namespace {

std::vector<std::vector<int>> sorted(std::vector<std::vector<int>> components) {
  for (auto& component : components) std::sort(component.begin(), component.end());
  return components;
}

}  // namespace

TEST_CASE("strong components: each comes behind all that it reaches", "[graph]") {
  // 0 -> (1 <-> 2) -> 3, and 4 alone.
  const std::vector<std::vector<int>> next{{1}, {2}, {1, 3}, {}, {}};
  CHECK(sorted(strong_components(next, Roots::FirstToLast)) ==
        std::vector<std::vector<int>>{{3}, {1, 2}, {0}, {4}});
  CHECK(sorted(strong_components(next, Roots::LastToFirst)) ==
        std::vector<std::vector<int>>{{4}, {3}, {1, 2}, {0}});
}

TEST_CASE("strong components: two cycles that share a vertex are one, and deep chains are searched",
          "[graph]") {
  CHECK(sorted(strong_components({{1}, {0, 2}, {3}, {1}}, Roots::FirstToLast)) ==
        std::vector<std::vector<int>>{{0, 1, 2, 3}});
  std::vector<std::vector<int>> chain(100'000);
  for (int v = 0; v + 1 < 100'000; ++v) chain[static_cast<std::size_t>(v)].push_back(v + 1);
  CHECK(strong_components(chain, Roots::FirstToLast).size() == chain.size());
}
