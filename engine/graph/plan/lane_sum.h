#pragma once

#include <cstddef>
#include <vector>

#include "engine/graph/node.h"

namespace tactus {

/// The order in which `mix` adds lanes, which decides the last bits of its sum: lane k takes in lanes k + 8,
/// k + 16 … one after the other; what is then left is added in halves, k and k + 4, k and k + 2, k and k + 1.
template <class Value, class Add>
Value add_lanes(const std::vector<Value>& lanes, Add add) {
  constexpr std::size_t kStrands = kWide;
  std::vector<Value> strands;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    if (i < kStrands)
      strands.push_back(lanes[i]);
    else
      strands[i % kStrands] = add(strands[i % kStrands], lanes[i]);
  }
  for (std::size_t half = kStrands / 2; half > 0; half /= 2)
    for (; strands.size() > half; strands.pop_back())
      strands[strands.size() - 1 - half] = add(strands[strands.size() - 1 - half], strands.back());
  return strands.front();
}

}  // namespace tactus
