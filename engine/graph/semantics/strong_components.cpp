#include <algorithm>
#include <limits>

#include "engine/core/index.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

std::vector<std::vector<int>> strong_components(const std::vector<std::vector<int>>& next, Roots roots) {
  constexpr int kNew = -1, kDone = std::numeric_limits<int>::max();
  struct Visit {
    int vertex, number;
    std::size_t edge = 0;
  };
  std::vector<std::vector<int>> components;
  std::vector<int> low(next.size(), kNew);  // the lowest number that a vertex reaches in its component
  std::vector<int> open;                    // those whose component is not complete
  std::vector<Visit> path;
  auto enter = [&, number = 0](int v) mutable {
    path.push_back({v, low[index(v)] = number++});
    open.push_back(v);
  };
  const auto leave = [&](int v) {
    const auto end = std::find(open.rbegin(), open.rend(), v) + 1;
    for (const int member : components.emplace_back(open.rbegin(), end)) low[index(member)] = kDone;
    open.erase(end.base(), open.end());
  };
  const int count = static_cast<int>(next.size());
  for (int i = 0; i < count; ++i) {
    const int root = roots == Roots::FirstToLast ? i : count - 1 - i;
    if (low[index(root)] == kNew) enter(root);
    while (!path.empty()) {
      auto& [v, number, edge] = path.back();
      int& lowest = low[index(v)];
      if (edge == next[index(v)].size()) {
        if (lowest == number) leave(v);
        path.pop_back();
      } else if (const int to = next[index(v)][edge]; low[index(to)] == kNew) {
        enter(to);  // this edge again once `to` was left
      } else {
        lowest = std::min(lowest, low[index(to)]);
        ++edge;
      }
    }
  }
  return components;
}

}  // namespace tactus
