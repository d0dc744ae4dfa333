#include "engine/graph/semantics/operators.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "engine/core/named.h"
#include "engine/graph/file/value.h"

namespace tactus {
namespace {

constexpr bool is_in_order() {
  for (std::size_t i = 0; i < kOperators.size(); ++i)
    if (entry_of(kOperators[i].op) != i) return false;
  return kOperators.back().op == Expression::Op::Tanh;
}
static_assert(is_in_order());

constexpr std::array<std::pair<std::string_view, double>, 2> kConstants{
    {{"pi", kPi}, {"e", 0x1.5bf0a8b145769p+1}}};

/// What the ends of a range may miss by the rounding of a function between them.
Interval widened(Interval range) {
  constexpr double kRounding = 1e-15;
  return {range.low - kRounding * std::abs(range.low), range.high + kRounding * std::abs(range.high)};
}

Interval overlap(Interval a, Interval b) { return {std::max(a.low, b.low), std::min(a.high, b.high)}; }

bool is_inside(const Operator& type, double x) {
  return type.domain.contains(x) && !(type.open && (x == type.domain.low || x == type.domain.high));
}

/// Of a function of one operand that rises or falls.
Interval monotone_range(const Operator& type, Interval in) {
  const auto inside = overlap(in, type.domain);
  const double first = type.value(inside.low, 0, 0), last = type.value(inside.high, 0, 0);
  const bool rises = type.shape == Operator::Shape::Rises;
  return overlap(widened(rises ? Interval{first, last} : Interval{last, first}), type.codomain);
}

}  // namespace

const Operator* find_function(std::string_view name) {
  const auto found = std::ranges::find_if(
      kOperators, [&](const Operator& type) { return type.is_function() && type.name == name; });
  return found == kOperators.end() ? nullptr : &*found;
}

const std::vector<std::string>& function_names() {
  static const auto names = [] {
    std::vector<std::string> found;
    for (const auto& type : kOperators)
      if (type.is_function()) found.emplace_back(type.name);
    return found;
  }();
  return names;
}

const double* find_constant(std::string_view name) {
  const auto* const found = std::ranges::find(kConstants, name, &std::pair<std::string_view, double>::first);
  return found == kConstants.end() ? nullptr : &found->second;
}

std::span<const std::string_view> reserved_names() {
  static constexpr std::string_view kReserved[] = {
      "system", "min", "max", "abs", kConstants[0].first, kConstants[1].first};
  return kReserved;
}

bool is_outside(const Operator& type, const OperandRanges& in) {
  if (type.outside != nullptr) return type.outside(in);
  const auto inside = overlap(in[0], type.domain);
  if (inside.low > inside.high) return true;
  return type.open && inside.single() && !is_inside(type, inside.low);
}

Interval range_of(const Operator& type, const OperandRanges& in) {
  if (type.range != nullptr) return type.range(in);
  if (is_outside(type, in)) return Interval::exactly(0);
  if (type.operands == 1 && in[0].single()) {
    const double value = type.value(in[0].low, 0, 0);
    return Interval::exactly(std::isfinite(value) ? value : 0);
  }
  const auto range = type.shape == Operator::Shape::Other ? type.codomain : monotone_range(type, in[0]);
  const bool may_fault =
      type.can_fail && !(range.bounded() && is_inside(type, in[0].low) && is_inside(type, in[0].high));
  return may_fault ? range.joined(Interval::exactly(0)) : range;
}

const Expression* definition_of(Expression::Op op) {
  static const auto definitions = [] {
    std::map<Expression::Op, Expression> made;
    for (const auto& type : kOperators)
      if (type.definition != nullptr) made.emplace(type.op, parse_expression(type.definition, {}).value());
    return made;
  }();
  const auto found = definitions.find(op);
  return found == definitions.end() ? nullptr : &found->second;
}

Interval mod_range(const OperandRanges& in) {
  const auto [a, b, none] = in;
  if (a.single() && b.single() && b.low != 0) return Interval::exactly(math::mod(a.low, b.low));
  if (a.low >= 0 && a.high < b.low) return a;
  return {std::min(0.0, b.low), std::max(0.0, b.high)};
}

Interval mix_range(const OperandRanges& in) {
  const auto [a, b, t] = in;
  if (t.low >= 0 && t.high <= 1) return widened(a.joined(b));
  return a + (b - a) * t;
}

Interval pow_range(const OperandRanges& in) {
  const auto [a, b, none] = in;
  const bool whole = b.single() && std::floor(b.low) == b.low;
  const bool even = whole && std::floor(0.5 * b.low) == 0.5 * b.low;
  if (a.single() && b.single()) {
    const double value = math::pow(a.low, b.low);
    return Interval::exactly(std::isfinite(value) ? value : 0);
  }
  if (a.low < 0 && !(whole && b.low >= 0)) return {};
  if (!a.bounded() || !b.bounded()) return a.low >= 0 || even ? Interval{0, kUnlimited} : Interval{};
  const auto [low, high] = std::minmax({math::pow(a.low, b.low), math::pow(a.low, b.high),
                                        math::pow(a.high, b.low), math::pow(a.high, b.high)});
  // Above 0 it is monotone in both; a pole or an overflow faults, and a fault gives 0.
  const auto range = widened({std::isnan(low) ? 0 : low, std::isnan(high) ? kUnlimited : high});
  const bool to_zero = !range.bounded() || a.low == 0 || (even && a.contains(0));
  return to_zero ? range.joined(Interval::exactly(0)) : range;
}

bool pow_is_outside(const OperandRanges& in) {
  const auto [a, b, none] = in;
  if (a.single() && a.low == 0) return b.high < 0;
  return a.high < 0 && b.single() && std::floor(b.low) != b.low;
}

double pow_slope(const OperandValues& at, int which) {
  const double a = at[0], b = at[1];
  return which == 0 ? b * math::pow(a, b - 1) : math::pow(a, b) * math::log(a);
}

double atan2_slope(const OperandValues& at, int which) {
  const double y = at[0], x = at[1], square = x * x + y * y;
  return which == 0 ? x / square : -y / square;
}

}  // namespace tactus
