#include "engine/study/stability/models/stability_law.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace tactus {
namespace {

/// Of a minimum (or maximum) of something that moves and something that does not, the moving one limits when
/// touched; of two that move, the one that does so now.
double chosen(const Operands& operands, int which, bool first, bool touched) {
  const auto& moves = operands.moves;
  if (touched && moves[0] != moves[1]) return moves[static_cast<std::size_t>(which)] ? 1 : 0;
  return first == (which == 0) ? 1 : 0;
}

}  // namespace

int operands_of(Expression::Op op) {
  switch (op) {
    case Expression::Op::Add:
    case Expression::Op::Subtract:
    case Expression::Op::Multiply:
    case Expression::Op::Divide:
    case Expression::Op::Min:
    case Expression::Op::Max:
      return 2;
    default:
      return 1;
  }
}

double slope_of(Expression::Op op, const Operands& operands, int which, bool touched) {
  const double a = operands.a, b = operands.b;
  switch (op) {
    case Expression::Op::Negate:
      return -1;
    case Expression::Op::Subtract:
      return which == 0 ? 1 : -1;
    case Expression::Op::Multiply:
      return which == 0 ? b : a;
    case Expression::Op::Divide:
      return b == 0 ? 0 : which == 0 ? 1 / b : -a / (b * b);
    case Expression::Op::Min:
      return chosen(operands, which, a < b, touched);
    case Expression::Op::Max:
      return chosen(operands, which, a > b, touched);
    case Expression::Op::Abs:
      return a < 0 ? -1 : a > 0 || touched ? 1 : 0;
    default:
      return 1;
  }
}

bool is_spring(const NodeType& type, std::size_t input, std::size_t output) {
  return type.stateless && type.inputs[input].unit == "m" && type.outputs[output].unit == "N";
}

double answer_at(const Node& node, const NodeType& type, const std::vector<double>& at,
                 const std::vector<bool>& moves) {
  double sum = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!moves[i]) continue;
    const double slope = node.response(static_cast<int>(i), 0, 1.0, at).value_or(0.0).real();
    sum += is_spring(type, i, 0) ? std::max(0.0, -slope) : std::abs(slope);
  }
  return std::isfinite(sum) ? sum : 0;
}

Summit summit(const std::function<double(double)>& height, double start, const std::vector<double>& middles) {
  Summit best{start, height(start)};
  const auto rises = [&](double at) {
    const double found = height(at);
    if (found <= best.height * (1 + 1e-9)) return false;
    best = {at, found};
    return true;
  };
  constexpr int kPerDecade = 12;
  double stride = 0;
  for (const double middle : middles)
    for (int step = -6 * kPerDecade; step <= 3 * kPerDecade; ++step)
      for (const double side : {-1.0, 1.0}) {
        const double away = std::pow(10.0, step / static_cast<double>(kPerDecade));
        if (rises(middle + side * away)) stride = 0.1 * away;
      }
  for (int halved = 0; stride > 0 && halved < 40;)
    if (!rises(best.at + stride) && !rises(best.at - stride)) stride *= 0.5, ++halved;
  return best;
}

SteepPlace steepest(const Node& node, const NodeType& type, const std::vector<double>& at,
                    const std::vector<bool>& moves) {
  const double rest = answer_at(node, type, at, moves);
  SteepPlace best{at, rest};
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!moves[i]) continue;
    if (best.input < 0) best.input = static_cast<int>(i);
    auto there = at;
    const auto height = [&](double value) {
      there[i] = value;
      const double found = answer_at(node, type, there, moves);
      best.nonlinear |= std::abs(found - rest) > 1e-6 * rest;
      return found;
    };
    std::vector<double> middles{at[i], 0.0};
    for (std::size_t other = 0; other < at.size(); ++other)
      if (!moves[other]) middles.push_back(at[other]);
    const auto found = summit(height, at[i], middles);
    if (found.height <= best.answer * (1 + 1e-9)) continue;
    best.at = at;
    best.at[i] = found.at;
    best.answer = found.height;
    best.input = static_cast<int>(i);
  }
  return best;
}

}  // namespace tactus
