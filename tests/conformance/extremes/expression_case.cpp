#include "tests/conformance/extremes/expression_case.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"

namespace tactus::test {
namespace {

using Op = Expression::Op;
constexpr int kFrames = 200;
constexpr double kSmallestNormal = std::numeric_limits<double>::min();

struct Operator {
  Op op;
  const char* text;  ///< of a graph file, with both operands
  long double (*value)(long double, long double);
};
using Real = long double;
constexpr std::array kOperators = {
    Operator{Op::Negate, "-{}", [](Real a, Real) { return -a; }},
    Operator{Op::Add, "{} + {}", [](Real a, Real b) { return a + b; }},
    Operator{Op::Subtract, "{} - {}", [](Real a, Real b) { return a - b; }},
    Operator{Op::Multiply, "{} * {}", [](Real a, Real b) { return a * b; }},
    Operator{Op::Divide, "{} / {}", [](Real a, Real b) { return b == 0 ? 0 : a / b; }},
    Operator{Op::Min, "min({}, {})", [](Real a, Real b) { return a < b ? a : b; }},
    Operator{Op::Max, "max({}, {})", [](Real a, Real b) { return a > b ? a : b; }},
    Operator{Op::Abs, "abs({})", [](Real a, Real) { return a < 0 ? -a : a; }}};

const Operator& operator_of(Op op) {
  return *std::find_if(kOperators.begin(), kOperators.end(),
                       [&](const auto& entry) { return entry.op == op; });
}

bool takes_two(Op op) { return op != Op::Negate && op != Op::Abs; }

std::string text_of(const ExpressionCase& c) {
  const auto operand = [](bool moves, const char* name, double value) {
    return moves ? std::string{name} : fmt::format("({:.17g})", value);
  };
  return fmt::format(fmt::runtime(operator_of(c.op).text), operand(c.a_moves, "a", c.a),
                     operand(c.b_moves, "b", c.b));
}

}  // namespace

std::string ExpressionCase::name() const {
  return fmt::format("{} with a = {:g}, b = {:g}", text_of(*this), a, b);
}

std::vector<ExpressionCase> expression_cases() {
  const auto values = extreme_values({}, false);
  std::vector<ExpressionCase> cases;
  for (const auto& entry : kOperators)
    for (const double a : values)
      for (const double b : takes_two(entry.op) ? values : std::vector{0.0})
        for (const int moves : {0, 1, 2, 3})
          if (takes_two(entry.op) || moves < 2)
            cases.push_back({entry.op, a, b, moves % 2 == 1, moves / 2 == 1});
  return cases;
}

Judgement judge(const ExpressionCase& c) {
  const auto wrong = [](std::string reason) { return Judgement{Verdict::Wrong, std::move(reason)}; };
  const auto text =
      "format = 1\n[inputs]\na = {}\nb = {}\n[outputs]\ny = { from = \"" + text_of(c) + "\" }\n";
  auto plan = compile(parse_graph_leniently(text, "extremes.toml"), standard_nodes(), {});
  const double a = taken_for(c.a), b = taken_for(c.b);
  const Real exact = operator_of(c.op).value(a, b);
  const bool overflows = std::abs(exact) > std::numeric_limits<double>::max();
  if (!plan) {
    const auto& error = plan.error().front();
    const bool divides_by_zero = c.op == Op::Divide && !c.b_moves && b == 0;
    if (!error.where.starts_with("extremes.toml:6:") || error.remedy.empty())
      return wrong("refused without place or remedy: " + to_string(error));
    if (!divides_by_zero && !overflows) return wrong("refused: " + to_string(error));
    return {Verdict::Refused, to_string(error)};
  }
  Player player{std::move(*plan)};
  const Channels in{Samples(kFrames, c.a), Samples(kFrames, c.b)};
  const auto out = run(player, in, kFrames, {64});
  const bool faults = !player.faults().empty();
  if (first_difference(out, run(player, in, kFrames, {1, 37, 100, 3})) != "") return wrong("blocks matter");
  if (overflows && faults && out[0][0] == 0) return {Verdict::Right, "the result overflows, and is reported"};
  if (faults) return wrong("a fault");
  for (const double y : out[0])
    if (!(std::abs(y - exact) <= 2e-16L * std::abs(exact) + kSmallestNormal))
      return wrong(fmt::format("{} instead of {}", y, static_cast<double>(exact)));
  return {Verdict::Right, "long double"};
}

}  // namespace tactus::test
