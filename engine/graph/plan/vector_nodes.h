#pragma once

#include <array>

#include "engine/graph/node.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

// The steps that `vectorise` puts between wide nodes (see Node::widened).

/// One operator of an expression on kWide lanes: out = op(in[0], in[1]), as `apply` says.
class VectorOperation : public Node {
 public:
  explicit VectorOperation(Expression::Op op) : op_(op) {}
  void process(const NodeBlock& block) noexcept override;
  void reset() noexcept override {}

 private:
  Expression::Op op_;
};

/// kWide signals, put side by side.
class Pack : public Node {
 public:
  void process(const NodeBlock& block) noexcept override;
  void reset() noexcept override {}
};

/// The sum of `lanes` lanes that stand in wide signals, in the order of `add_lanes`.
class LaneSum : public Node {
 public:
  explicit LaneSum(int lanes) : lanes_(lanes) {}
  void process(const NodeBlock& block) noexcept override;
  void reset() noexcept override {}

 private:
  int lanes_;
  std::array<double, static_cast<std::size_t>(kWide) * kMaxPiece> sums_;
};

}  // namespace tactus
