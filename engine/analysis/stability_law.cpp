#include "engine/analysis/stability_law.h"

#include <cmath>
#include <complex>

namespace tactus {
namespace {

double slopes_at(const Node& node, const std::vector<double>& at, const std::vector<bool>& moves) {
  double sum = 0;
  for (std::size_t i = 0; i < at.size(); ++i)
    if (moves[i]) sum += std::abs(node.response(static_cast<int>(i), 0, 1.0, at).value_or(0.0));
  return std::isfinite(sum) ? sum : 0;
}

/// Of a minimum (or maximum) of something that moves and something that does not, the moving one limits when
/// touched; of two that move, the one that does so now.
double chosen(const Operands& operands, int which, bool first, bool touched) {
  const auto& moves = operands.moves;
  if (touched && moves[0] != moves[1]) return moves[static_cast<std::size_t>(which)] ? 1 : 0;
  return first == (which == 0) ? 1 : 0;
}

}  // namespace

int operands_of(Term::Op op) {
  switch (op) {
    case Term::Op::Add:
    case Term::Op::Subtract:
    case Term::Op::Multiply:
    case Term::Op::Divide:
    case Term::Op::Min:
    case Term::Op::Max:
      return 2;
    default:
      return 1;
  }
}

double slope_of(Term::Op op, const Operands& operands, int which, bool touched) {
  const double a = operands.a, b = operands.b;
  switch (op) {
    case Term::Op::Negate:
      return -1;
    case Term::Op::Subtract:
      return which == 0 ? 1 : -1;
    case Term::Op::Multiply:
      return which == 0 ? b : a;
    case Term::Op::Divide:
      return b == 0 ? 0 : which == 0 ? 1 / b : -a / (b * b);
    case Term::Op::Min:
      return chosen(operands, which, a < b, touched);
    case Term::Op::Max:
      return chosen(operands, which, a > b, touched);
    case Term::Op::Abs:
      return a < 0 ? -1 : a > 0 || touched ? 1 : 0;
    default:
      return 1;
  }
}

std::vector<double> steepest(const Node& node, const std::vector<double>& at,
                             const std::vector<bool>& moves) {
  auto best = at;
  double most = slopes_at(node, at, moves) * (1 + 1e-9);
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!moves[i]) continue;
    for (int step = -72; step <= 36; ++step) {
      for (const double side : {-1.0, 1.0}) {
        auto there = at;
        there[i] += side * std::pow(10.0, step / 12.0);
        const double slopes = slopes_at(node, there, moves);
        if (slopes <= most) continue;
        most = slopes * (1 + 1e-9);
        best = there;
      }
    }
  }
  return best;
}

std::optional<double> stands_for(std::string_view type, int input) {
  const bool follows = type == "quantiser" || type == "slew" || type == "sample_hold";
  return follows && input == 0 ? std::optional{1.0} : std::nullopt;
}

}  // namespace tactus
