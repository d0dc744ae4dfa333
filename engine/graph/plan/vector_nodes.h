#pragma once

// Thread: [control]; overrides of Node as it says.

#include <array>
#include <cstddef>
#include <vector>

#include "engine/graph/node.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

// The steps that `vectorise` puts between vectorised nodes (see Node::vectorised).

/// One operator of an expression on kVectorWidth lanes: out = op(in[0], in[1]), as `apply` says.
class VectorOperation : public Node {
 public:
  explicit VectorOperation(Expression::Op op) : op_(op) {}
  void process(const NodeBlock& block) noexcept override;
  void reset() noexcept override {}

 private:
  Expression::Op op_;
};

/// kVectorWidth scalar signals as one vectorised signal.
class Pack : public Node {
 public:
  void process(const NodeBlock& block) noexcept override;
  void reset() noexcept override {}
};

/// The sum of `lanes` lanes of vectorised signals, in the order of `add_lanes`.
class LaneSum : public Node {
 public:
  explicit LaneSum(int lanes) : lanes_(lanes) {}
  void process(const NodeBlock& block) noexcept override;
  void reset() noexcept override {}

 private:
  int lanes_;
  std::array<double, index(kVectorWidth) * kMaxSubBlock> sums_;
};

/// The order in which `mix` adds lanes, which decides the last bits of its sum: lane k takes in lanes k + 8,
/// k + 16 … one after the other; what is then left is added in halves, k and k + 4, k and k + 2, k and k + 1.
template <class Value, class Add>
Value add_lanes(const std::vector<Value>& lanes, Add add) {
  constexpr std::size_t kStrands = kVectorWidth;
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
