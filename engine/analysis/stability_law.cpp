#include "engine/analysis/stability_law.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace tactus {
namespace {

class SteepSearch {
 public:
  SteepSearch(const Node& node, const NodeType& type, const std::vector<double>& at,
              const std::vector<bool>& moves)
      : node_(node), type_(type), moves_(moves), best_{at, answer(at), false} {}

  SteepPlace run() {
    const auto start = best_.at;
    for (std::size_t i = 0; i < start.size(); ++i) {
      if (!moves_[i]) continue;
      look_around(start, i, start[i]);
      look_around(start, i, 0.0);
      for (std::size_t other = 0; other < start.size(); ++other)
        if (!moves_[other]) look_around(start, i, start[other]);
    }
    if (climbing_ >= 0) climb();
    return best_;
  }

 private:
  double answer(const std::vector<double>& at) const {
    double sum = 0;
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (!moves_[i]) continue;
      const double slope = node_.response(static_cast<int>(i), 0, 1.0, at).value_or(0.0).real();
      sum += is_spring(type_, i, 0) ? std::max(0.0, -slope) : std::abs(slope);
    }
    return std::isfinite(sum) ? sum : 0;
  }

  /// Whether it answers more there, by more than rounding.
  bool try_at(const std::vector<double>& at) {
    const double found = answer(at);
    best_.bends |= std::abs(found - best_.answer) > 1e-6 * best_.answer;
    if (found <= best_.answer * (1 + 1e-9)) return false;
    best_.at = at;
    best_.answer = found;
    return true;
  }

  void look_around(std::vector<double> at, std::size_t input, double middle) {
    constexpr int kPerDecade = 12;
    for (int step = -6 * kPerDecade; step <= 3 * kPerDecade; ++step)
      for (const double side : {-1.0, 1.0}) {
        const double away = std::pow(10.0, step / static_cast<double>(kPerDecade));
        at[input] = middle + side * away;
        if (try_at(at)) climbing_ = static_cast<int>(input), stride_ = 0.1 * away;
      }
  }

  void climb() {
    const auto input = static_cast<std::size_t>(climbing_);
    for (int halved = 0; halved < 40;) {
      auto up = best_.at, down = best_.at;
      up[input] += stride_;
      down[input] -= stride_;
      if (!try_at(up) && !try_at(down)) stride_ *= 0.5, ++halved;
    }
  }

  const Node& node_;
  const NodeType& type_;
  const std::vector<bool>& moves_;
  SteepPlace best_;
  int climbing_ = -1;
  double stride_ = 0;
};

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

bool is_spring(const NodeType& type, std::size_t input, std::size_t output) {
  return type.stateless && type.inputs[input].unit == "m" && type.outputs[output].unit == "N";
}

SteepPlace steepest(const Node& node, const NodeType& type, const std::vector<double>& at,
                    const std::vector<bool>& moves) {
  return SteepSearch{node, type, at, moves}.run();
}

std::optional<double> stands_for(std::string_view type, int input) {
  const bool follows = type == "quantiser" || type == "slew" || type == "sample_hold";
  return follows && input == 0 ? std::optional{1.0} : std::nullopt;
}

}  // namespace tactus
