#include "tests/conformance/extremes/expression_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"

namespace tactus::test {
namespace {

using Op = Expression::Op;
using Real = long double;
constexpr int kFrames = 200;
constexpr double kSmallestNormal = std::numeric_limits<double>::min();
constexpr Real kOutside = std::numeric_limits<Real>::quiet_NaN();
/// Of arithmetic, and of functions: 2.5 units in the last place.
constexpr Real kRounding = 2e-16L, kFunction = 5.6e-16L;
/// Where sin, cos and tan keep their error.
constexpr double kLargestAngle = 1.5e9;

struct Reference {
  Op op;
  Real (*value)(Real a, Real b, Real c);
  Real tolerance = kRounding;
};

Real floored_rest(Real a, Real b) {
  if (b == 0) return kOutside;
  const Real rest = std::fmod(a, b);
  return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest;
}

constexpr Reference kReferences[] = {
    {Op::Signal, [](Real a, Real, Real) { return a; }},
    {Op::Negate, [](Real a, Real, Real) { return -a; }},
    {Op::Add, [](Real a, Real b, Real) { return a + b; }},
    {Op::Subtract, [](Real a, Real b, Real) { return a - b; }},
    {Op::Multiply, [](Real a, Real b, Real) { return a * b; }},
    {Op::Divide, [](Real a, Real b, Real) { return b == 0 ? 0 : a / b; }},
    {Op::Less, [](Real a, Real b, Real) { return a < b ? 1.0L : 0.0L; }},
    {Op::LessOrEqual, [](Real a, Real b, Real) { return a <= b ? 1.0L : 0.0L; }},
    {Op::Greater, [](Real a, Real b, Real) { return a > b ? 1.0L : 0.0L; }},
    {Op::GreaterOrEqual, [](Real a, Real b, Real) { return a >= b ? 1.0L : 0.0L; }},
    {Op::Equal, [](Real a, Real b, Real) { return a == b ? 1.0L : 0.0L; }},
    {Op::NotEqual, [](Real a, Real b, Real) { return a != b ? 1.0L : 0.0L; }},
    {Op::Min, [](Real a, Real b, Real) { return std::min(a, b); }},
    {Op::Max, [](Real a, Real b, Real) { return std::max(a, b); }},
    {Op::Abs, [](Real a, Real, Real) { return std::abs(a); }},
    {Op::Sign, [](Real a, Real, Real) { return a > 0   ? 1.0L
                                               : a < 0 ? -1.0L
                                                       : 0.0L; }},
    {Op::Floor, [](Real a, Real, Real) { return std::floor(a); }},
    {Op::Ceil, [](Real a, Real, Real) { return std::ceil(a); }},
    {Op::Round, [](Real a, Real, Real) { return std::round(a); }},
    {Op::Mod, [](Real a, Real b, Real) { return floored_rest(a, b); }},
    {Op::Clamp, [](Real a, Real b, Real c) { return std::max(b, std::min(c, a)); }},
    {Op::Mix, [](Real a, Real b, Real c) { return a + (b - a) * c; }},
    {Op::Select, [](Real a, Real b, Real c) { return a != 0 ? b : c; }},
    {Op::Sqrt, [](Real a, Real, Real) { return std::sqrt(a); }},
    {Op::Pow, [](Real a, Real b, Real) { return a == 0 && b < 0 ? kOutside : std::pow(a, b); }, kFunction},
    {Op::Exp, [](Real a, Real, Real) { return std::exp(a); }, kFunction},
    {Op::Log, [](Real a, Real, Real) { return a > 0 ? std::log(a) : kOutside; }, kFunction},
    {Op::Log2, [](Real a, Real, Real) { return a > 0 ? std::log2(a) : kOutside; }, kFunction},
    {Op::Log10, [](Real a, Real, Real) { return a > 0 ? std::log10(a) : kOutside; }, kFunction},
    {Op::Sin, [](Real a, Real, Real) { return std::sin(a); }, kFunction},
    {Op::Cos, [](Real a, Real, Real) { return std::cos(a); }, kFunction},
    {Op::Tan, [](Real a, Real, Real) { return std::tan(a); }, kFunction},
    {Op::Asin, [](Real a, Real, Real) { return std::asin(a); }, kFunction},
    {Op::Acos, [](Real a, Real, Real) { return std::acos(a); }, kFunction},
    {Op::Atan, [](Real a, Real, Real) { return std::atan(a); }, kFunction},
    {Op::Atan2, [](Real a, Real b, Real) { return a == 0 && b == 0 ? 0 : std::atan2(a, b); }, kFunction},
    {Op::Tanh, [](Real a, Real, Real) { return std::tanh(a); }, kFunction},
};
static_assert(std::size(kReferences) == kOperators.size());

const Reference& reference_of(Op op) { return *std::ranges::find(kReferences, op, &Reference::op); }

std::string text_of(const ExpressionCase& c) {
  static constexpr const char* kNames[] = {"a", "b", "c"};
  const auto& type = operator_of(c.op);
  std::vector<std::string> operands;
  for (std::size_t i = 0; i < index(type.operands); ++i)
    operands.push_back(c.moves[i] ? kNames[i] : fmt::format("({:.17g})", c.at[i]));
  if (type.is_function()) return fmt::format("{}({})", type.name, fmt::join(operands, ", "));
  if (type.operands == 2) return fmt::format("{} {} {}", operands[0], type.name, operands[1]);
  return c.op == Op::Signal ? operands[0] : type.name + operands[0];
}

/// All of `values` for each operand; the third takes three of them.
void add_cases(const Operator& type, const std::vector<double>& values, std::vector<ExpressionCase>& cases) {
  const std::vector<double> none{0.0}, few{0.0, 0.5, -1e300};
  for (const double a : values)
    for (const double b : type.operands > 1 ? values : none)
      for (const double c : type.operands > 2 ? few : none)
        for (int moves = 0; moves < 1 << type.operands; ++moves)
          cases.push_back({type.op, {a, b, c}, {(moves & 1) != 0, (moves & 2) != 0, (moves & 4) != 0}});
}

/// A remainder as close to the whole period as its last bit counts as none: [0, b) does not have its end.
bool is_whole_period(const ExpressionCase& c, const OperandValues& at, double y, Real exact) {
  return c.op == Op::Mod && y == 0 && static_cast<double>(exact) == at[1];
}

/// Whether the operator only specifies bounds of its value for these operands, not the value itself.
bool only_bounded(const ExpressionCase& c, const OperandValues& at) {
  if (c.op == Op::Sin || c.op == Op::Cos || c.op == Op::Tan) return std::abs(at[0]) > kLargestAngle;
  return c.op == Op::Mod && std::abs(at[0] / at[1]) > 0x1p51;
}

bool within_bounds(const ExpressionCase& c, const OperandValues& at, double y) {
  if (c.op == Op::Mod) return std::abs(y) < std::abs(at[1]);
  return c.op == Op::Tan ? std::isfinite(y) : std::abs(y) <= 1;
}

}  // namespace

std::string ExpressionCase::name() const {
  return fmt::format("{} with a = {:g}, b = {:g}, c = {:g}", text_of(*this), at[0], at[1], at[2]);
}

std::vector<ExpressionCase> expression_cases() {
  const auto values = extreme_values({}, false);
  std::vector<ExpressionCase> cases;
  for (const auto& type : kOperators) add_cases(type, values, cases);
  return cases;
}

Judgement judge(const ExpressionCase& c) {
  const auto wrong = [](std::string reason) { return Judgement{Verdict::Wrong, std::move(reason)}; };
  const auto text =
      "format = 1\n[inputs]\na = {}\nb = {}\nc = {}\n[outputs]\ny = { from = \"" + text_of(c) + "\" }\n";
  auto plan = compile(parse_graph_leniently(text, "extremes.toml"), standard_nodes(), {});
  const OperandValues at{taken_for(c.at[0]), taken_for(c.at[1]), taken_for(c.at[2])};
  const auto& reference = reference_of(c.op);
  const Real exact = reference.value(Real(at[0]), Real(at[1]), Real(at[2]));
  const bool fails = !(std::abs(exact) <= Real(std::numeric_limits<double>::max()));
  if (!plan) {
    const auto& error = plan.error().front();
    const bool divides_by_zero = c.op == Op::Divide && !c.moves[1] && at[1] == 0;
    if (!error.where.starts_with("extremes.toml:7:") || error.remedy.empty())
      return wrong("refused without place or remedy: " + to_string(error));
    if (!divides_by_zero && !fails) return wrong("refused: " + to_string(error));
    return {Verdict::Refused, to_string(error)};
  }
  Player player{std::move(*plan)};
  const Channels in{Samples(kFrames, c.at[0]), Samples(kFrames, c.at[1]), Samples(kFrames, c.at[2])};
  const auto out = run(player, in, kFrames, {64});
  const bool faults = !player.faults().empty();
  if (first_difference(out, run(player, in, kFrames, {1, 37, 100, 3})) != "") return wrong("blocks matter");
  // Of several steps, such as those of mix, one may overflow while the others give something.
  const bool in_steps = operator_of(c.op).definition != nullptr;
  if (fails && faults && (out[0][0] == 0 || in_steps))
    return {Verdict::Right, "outside the domain, or it overflows; reported"};
  if (faults) return wrong("a fault");
  for (const double y : out[0]) {
    if (only_bounded(c, at)) {
      if (!within_bounds(c, at, y)) return wrong(fmt::format("{} is out of bounds", y));
    } else if (!is_whole_period(c, at, y, exact) &&
               !(std::abs(Real(y) - exact) <=
                 reference.tolerance * std::abs(exact) + Real(kSmallestNormal))) {
      return wrong(fmt::format("{} instead of {}", y, static_cast<double>(exact)));
    }
  }
  return {Verdict::Right, "long double"};
}

}  // namespace tactus::test
