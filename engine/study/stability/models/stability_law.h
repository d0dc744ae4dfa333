#pragma once

// Thread: [any].

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "engine/graph/node.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

/// Where an operation of an expression stands.
struct Operands {
  double a = 0, b = 0;
  std::array<bool, 2> moves{};
};

/// [any] How many operands it has.
int operands_of(Expression::Op op);

/// [any] d(out)/d(operand `which`) of an operation. At a corner (a minimum, a maximum, an absolute value)
/// `touched` takes the side where the moving operand comes through.
double slope_of(Expression::Op op, const Operands& operands, int which, bool touched);

/// [any] Whether output `output` of a law is a force that answers a position at `input`.
bool is_spring(const NodeType& type, std::size_t input, std::size_t output);

/// A law without memory where it answers most.
struct SteepPlace {
  std::vector<double> at;  ///< its inputs there
  double answer = 0;       ///< sum of the slopes; of a force that answers a position only what pulls back
  bool nonlinear = false;  ///< it answers otherwise elsewhere
  int input = -1;          ///< what moved to get there; the first that can, where nothing had to
};

/// [any] How much it answers at `at`: the sum of its slopes.
double answer_at(const Node& node, const NodeType& type, const std::vector<double>& at,
                 const std::vector<bool>& moves);

struct Summit {
  double at = 0, height = 0;
};

/// [any] The highest place of a curve that can be found from `start` and around each of the middles: from
/// 1e-6 to 1e3 to both sides, and up from the best of these.
Summit summit(const std::function<double(double)>& height, double start, const std::vector<double>& middles);

/// [any] Looks around where the law stands, around 0, and around each of its inputs that rest (where a clip,
/// a wall or a notch begins), one moving input at a time.
SteepPlace steepest(const Node& node, const NodeType& type, const std::vector<double>& at,
                    const std::vector<bool>& moves);

}  // namespace tactus
