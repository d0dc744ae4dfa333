#include "export/fixed/arithmetic.h"

#include <fmt/format.h>

#include <utility>

namespace tactus {
namespace {

constexpr int kLeastExponent = -60, kMostExponent = 60;

/// 2^k, or nothing.
std::optional<int> exact_power_of_two(double value) {
  int exponent = 0;
  return std::frexp(std::abs(value), &exponent) == 0.5 ? std::optional{exponent - 1} : std::nullopt;
}

}  // namespace

FixedValue FixedArithmetic::number(double value) {
  FixedValue result;
  result.constant = value;
  result.range = Interval::exactly(value);
  return result;
}

int FixedArithmetic::fitting(Interval range, bool wide) const {
  const double size = std::max(std::abs(range.low), std::abs(range.high));
  if (!std::isfinite(size)) return kLeastExponent;
  const int coarsest = wide ? kMostExponent : std::min(kMostExponent, 2 * bits_);
  int exponent =
      size > 0 ? std::min(coarsest, static_cast<int>(std::floor(std::log2(most(wide) / size)))) : bits_ - 1;
  while (exponent > kLeastExponent && std::ldexp(size, exponent) > most(wide)) --exponent;
  return exponent;
}

std::string FixedArithmetic::literal(double value, int exponent, bool wide) const {
  const int bits = wide ? 2 * bits_ : bits_;
  double whole = std::nearbyint(std::ldexp(value, exponent));
  const double period = std::ldexp(1.0, bits);
  whole -= period * std::floor(whole / period + 0.5);
  if (whole >= period / 2) whole -= period;
  const auto text = fmt::format("{:.0f}", std::abs(whole));
  const std::string suffix = wide && bits_ == 32 ? "LL" : bits > 16 ? "L" : "";
  if (whole <= -period / 2) return fmt::format("(-{:.0f}{} - 1)", -whole - 1, suffix);
  return (whole < 0 ? "-" : "") + text + suffix;
}

std::string FixedArithmetic::aligned(const FixedValue& a, int exponent, bool wide, double& rounding) const {
  if (a.constant) {
    rounding +=
        std::abs(*a.constant - std::ldexp(std::nearbyint(std::ldexp(*a.constant, exponent)), -exponent));
    return literal(*a.constant, exponent, wide);
  }
  const int less = a.exponent - exponent;
  if (less > 0) rounding += std::ldexp(wide ? 1.0 : 0.5, -exponent);
  if (a.wide && !wide) {
    if (less > 0) return fmt::format("tactus_narrow({}, {})", a.text, less);
    return less < 0 ? fmt::format("tactus_more((tactus_word){}, {})", a.text, -less)
                    : "(tactus_word)" + a.text;
  }
  if (less > 0) return fmt::format("tactus_{}less({}, {})", wide ? "wide_" : "", a.text, less);
  if (less < 0) return fmt::format("tactus_{}more({}, {})", wide ? "wide_" : "", a.text, -less);
  return a.text;
}

FixedValue FixedArithmetic::finished(std::string text, int exponent, bool is_wide, Interval range,
                                     double error, bool wide) const {
  FixedValue result{std::move(text), exponent, range, error};
  if (wide && is_wide) {
    result.wide = true;
    const int fits = fitting(range, true);
    if (fits >= exponent) return result;
    result.text = fmt::format("tactus_wide_less({}, {})", result.text, exponent - fits);
    result.exponent = fits;
    result.error += std::ldexp(1.0, -fits);
    result.range = widened_by(range, std::ldexp(1.0, -fits));
    return result;
  }
  result.wide = is_wide;
  return is_wide ? word(result) : result;
}

FixedValue FixedArithmetic::word(const FixedValue& a) const {
  if (!a.wide || a.constant) return a;
  FixedValue result = a;
  result.wide = false;
  for (int exponent = std::min(a.exponent, fitting(a.range));; --exponent) {
    double rounding = 0;
    result.text = aligned(a, exponent, false, rounding);
    result.exponent = exponent;
    result.range = widened_by(a.range, rounding);
    result.error = a.error + rounding;
    if (fitting(result.range) >= exponent || exponent <= kLeastExponent) return result;
  }
}

FixedValue FixedArithmetic::combined(const char* name, const FixedValue& a, const FixedValue& b,
                                     Interval range, double error, bool wide,
                                     const std::function<Interval(double)>& with_rounding) const {
  // Wide ones have digits to spare: only one of them is moved.
  const int finest = a.constant   ? b.exponent
                     : b.constant ? a.exponent
                     : wide       ? std::min(a.exponent, b.exponent) + (a.wide && b.wide ? 0 : bits_ / 2)
                                  : std::max(a.exponent, b.exponent);
  for (int exponent = std::min(finest, fitting(range, wide));; --exponent) {
    double rounding = 0;
    const auto left = aligned(a, exponent, wide, rounding), right = aligned(b, exponent, wide, rounding);
    const auto rounded = with_rounding(rounding);
    if (fitting(rounded, wide) < exponent && exponent > kLeastExponent) continue;
    FixedValue result{fmt::format("tactus_{}{}({}, {})", wide ? "wide_" : "", name, left, right), exponent,
                      rounded, error + rounding};
    result.wide = wide;
    return result;
  }
}

FixedValue FixedArithmetic::sum(const FixedValue& a, const FixedValue& b, bool wide) const {
  if (a.constant && b.constant) return number(*a.constant + *b.constant);
  if (a.constant == 0.0) return wide ? b : word(b);
  if (b.constant == 0.0) return wide ? a : word(a);
  const auto range = a.range + b.range;
  if (!wide && (a.wide || b.wide)) return word(sum(a, b, true));
  return combined("sum", a, b, range, a.error + b.error, wide,
                  [&](double r) { return widened_by(range, r); });
}

FixedValue FixedArithmetic::difference(const FixedValue& a, const FixedValue& b, bool wide) const {
  if (a.constant && b.constant) return number(*a.constant - *b.constant);
  if (b.constant == 0.0) return wide ? a : word(a);
  if (a.constant == 0.0) return negative(wide ? b : word(b));
  const auto range = a.range - b.range;
  if (!wide && (a.wide || b.wide)) return word(difference(a, b, true));
  return combined("difference", a, b, range, a.error + b.error, wide,
                  [&](double r) { return widened_by(range, r); });
}

FixedValue FixedArithmetic::chosen(const char* name, const FixedValue& a, const FixedValue& b, bool low,
                                   bool wide) const {
  const auto of = [&](Interval x, Interval y) { return low ? min(x, y) : max(x, y); };
  if (a.constant && b.constant)
    return number(low ? std::min(*a.constant, *b.constant) : std::max(*a.constant, *b.constant));
  // One of them is always the one.
  if (low ? a.range.high <= b.range.low : a.range.low >= b.range.high) return wide ? a : word(a);
  if (low ? b.range.high <= a.range.low : b.range.low >= a.range.high) return wide ? b : word(b);
  // Both must fit where they are compared.
  const int finest = std::max(a.constant ? -99 : a.exponent, b.constant ? -99 : b.exponent);
  const bool inside =
      a.wide || b.wide ||
      std::min(finest, fitting(of(a.range, b.range))) > std::min(fitting(a.range), fitting(b.range));
  const auto result = combined(name, a, b, of(a.range, b.range), std::max(a.error, b.error), inside,
                               [&](double r) { return of(widened_by(a.range, r), widened_by(b.range, r)); });
  return wide ? result : word(result);
}
FixedValue FixedArithmetic::smaller(const FixedValue& a, const FixedValue& b, bool wide) const {
  return chosen("smaller", a, b, true, wide);
}
FixedValue FixedArithmetic::larger(const FixedValue& a, const FixedValue& b, bool wide) const {
  return chosen("larger", a, b, false, wide);
}

FixedValue FixedArithmetic::negative(const FixedValue& a) const {
  if (a.constant) return number(-*a.constant);
  FixedValue result = a;
  result.text = fmt::format("({})-{}", a.wide ? "tactus_wide" : "tactus_word", a.text);
  result.range = -a.range;
  result.flag = false;
  return result;
}

FixedValue FixedArithmetic::scaled(const FixedValue& a, double factor, bool wide) const {
  if (factor == 0) return number(0);
  if (const auto power = exact_power_of_two(factor)) {
    FixedValue result = a;
    result.exponent -= *power;
    result.flag = false;
    result.range = a.range * Interval::exactly(std::abs(factor));
    result.error = a.error * std::abs(factor);
    result = factor < 0 ? negative(result) : result;
    return wide ? result : word(result);
  }
  const int exponent = fitting(Interval::exactly(factor));
  const double rounded = std::ldexp(std::nearbyint(std::ldexp(factor, exponent)), -exponent);
  const double error = a.error * std::abs(factor) + a.size() * std::abs(rounded - factor);
  const auto range = a.range * Interval::exactly(rounded);
  if (!a.wide)
    return finished(fmt::format("tactus_product({}, {})", a.text, literal(factor, exponent)),
                    a.exponent + exponent, true, range, error, wide);
  // The upper parts of both, so that no product is wider than what there is.
  const double step = std::ldexp(1.0, bits_ - a.exponent - exponent);
  return finished(fmt::format("tactus_scaled({}, {})", a.text, literal(factor, exponent)),
                  a.exponent + exponent - bits_, true, widened_by(range, step), error + step, wide);
}

FixedValue FixedArithmetic::product(const FixedValue& a, const FixedValue& b, bool wide) const {
  if (a.constant && b.constant) return number(*a.constant * *b.constant);
  if (a.constant) return scaled(b, *a.constant, wide);
  if (b.constant) return scaled(a, *b.constant, wide);
  if (a.flag && b.flag) {
    FixedValue result{fmt::format("({} & {})", a.text, b.text), 0, {0, 1}};
    result.flag = true;
    return result;
  }
  if (a.flag) return choice(a, b, number(0), wide);
  if (b.flag) return choice(b, a, number(0), wide);
  const auto left = word(a), right = word(b);
  const double error = left.size() * right.error + right.size() * left.error + left.error * right.error;
  return finished(fmt::format("tactus_product({}, {})", left.text, right.text),
                  left.exponent + right.exponent, true, left.range * right.range, error, wide);
}

FixedValue FixedArithmetic::quotient(const FixedValue& a, const FixedValue& b) const {
  if (b.constant)
    return a.constant ? number(*b.constant == 0 ? 0 : *a.constant / *b.constant)
                      : product(a, number(1 / *b.constant));
  FixedValue top = a;
  if (a.constant) {
    top = number(*a.constant);
    top.exponent = fitting(a.range);
    top.error = 0;
    top.text = aligned(a, top.exponent, false, top.error);
    top.constant.reset();
  }
  top = word(top);
  const auto bottom = word(b);
  const double least = std::min(std::abs(bottom.range.low), std::abs(bottom.range.high));
  const auto range = divide(top.range, bottom.range);
  const double most = std::max(std::abs(range.low), std::abs(range.high));
  int exponent = fitting(widened_by(range, std::ldexp(1.0, -fitting(range))));
  const int by = std::clamp(exponent + bottom.exponent - top.exponent, 0, bits_ - 1);
  exponent = by + top.exponent - bottom.exponent;
  const double rounding = std::ldexp(0.5, -exponent);
  return {fmt::format("tactus_quotient({}, {}, {})", top.text, by, bottom.text), exponent,
          widened_by(range, rounding),
          (top.error + most * bottom.error) / std::max(least - bottom.error, 1e-300) + rounding};
}

FixedValue FixedArithmetic::size(const FixedValue& a) const {
  if (a.constant) return number(std::abs(*a.constant));
  const auto b = word(a);
  return {fmt::format("tactus_size({})", b.text), b.exponent, abs(b.range), b.error};
}

FixedValue FixedArithmetic::comparison(const char* sign, const FixedValue& a, const FixedValue& b) {
  FixedValue result;
  result.flag = true;
  result.range = {0, 1};
  double rounding = 0;
  const bool same = a.constant || b.constant || a.exponent == b.exponent;
  const auto& one = a.constant ? b : a;
  const auto fits = [&](const FixedValue& x, int exponent, bool wide) {
    return fitting(x.range, wide) >= exponent;
  };
  int exponent =
      same ? one.exponent
           : std::min(std::max(a.exponent, b.exponent), std::min(a.exponent, b.exponent) + bits_ - 1);
  const bool wide = a.wide || b.wide || !fits(a, exponent, false) || !fits(b, exponent, false);
  while (exponent > kLeastExponent &&
         ((!a.constant && !fits(a, exponent, wide)) || (!b.constant && !fits(b, exponent, wide))))
    --exponent;
  // A constant beyond every value of the other operand is replaced by the end of the range: the result is the
  // same.
  const double limit = std::ldexp(most(wide), -exponent);
  const auto within = [&](const FixedValue& x) {
    return x.constant ? number(std::clamp(*x.constant, -limit, limit)) : x;
  };
  const auto left = aligned(within(a), exponent, wide, rounding),
             right = aligned(within(b), exponent, wide, rounding);
  result.text = fmt::format("({} {} {})", left, sign, right);
  decide(a.error + b.error + rounding);
  return result;
}

FixedValue FixedArithmetic::choice(const FixedValue& condition, const FixedValue& a, const FixedValue& b,
                                   bool wide) const {
  const bool inside = a.wide || b.wide;
  const auto range = a.range.joined(b.range);
  auto text = condition.constant ? literal(*condition.constant, 0) : condition.text;
  if (!condition.flag) text += " != 0";
  const int finest = a.constant   ? (b.constant ? fitting(range) : b.exponent)
                     : b.constant ? a.exponent
                                  : std::max(a.exponent, b.exponent);
  for (int exponent = std::min(finest, fitting(range, inside));; --exponent) {
    double of_a = 0, of_b = 0;
    const auto left = aligned(a, exponent, inside, of_a), right = aligned(b, exponent, inside, of_b);
    FixedValue result{fmt::format("({} ? {} : {})", text, left, right), exponent,
                      widened_by(a.range, of_a).joined(widened_by(b.range, of_b)),
                      std::max(a.error + of_a, b.error + of_b)};
    if (fitting(result.range, inside) < exponent && exponent > kLeastExponent) continue;
    result.wide = inside;
    if (a.constant && b.constant && exponent == 0) result.flag = range.low == 0 && range.high == 1;
    return wide ? result : word(result);
  }
}

FixedValue FixedArithmetic::whole(const char* how, const FixedValue& a) {
  if (a.exponent <= 0 || a.flag) return a;
  const auto x = word(a);
  const std::string name = how;
  const int e = x.exponent;
  if (e >= bits_) return number(0);
  const auto up = [&](double part) { return literal(part, e); };
  auto result = x;
  result.exponent = 0;
  result.error = 0;
  result.range = {std::floor(x.range.low), std::ceil(x.range.high)};
  result.text = name == "floor" ? fmt::format("(tactus_word)({} >> {})", x.text, e)
                : name == "ceil"
                    ? fmt::format("(tactus_word)-((tactus_word)-{} >> {})", x.text, e)
                    : fmt::format("(tactus_word)(((tactus_wide){} + {}) >> {})", x.text, up(0.5), e);
  decide(x.error);
  return result;
}

FixedValue FixedArithmetic::modulo(const FixedValue& a, const FixedValue& b) {
  const auto x = word(a);
  const double period = *b.constant;
  double rounding = 0;
  FixedValue result{fmt::format("tactus_modulo({}, {})", x.text, aligned(b, x.exponent, false, rounding)),
                    x.exponent,
                    {0, period + rounding},
                    x.error + rounding * std::ceil(x.size() / period)};
  decide(result.error);
  return result;
}

FixedValue FixedArithmetic::sign(const FixedValue& a) {
  FixedValue result{fmt::format("(tactus_word)(({0} > 0) - ({0} < 0))", a.text), 0, {-1, 1}};
  decide(a.error);
  return result;
}

FixedValue FixedArithmetic::trigger(const FixedValue& a) {
  if (a.constant) return number(*a.constant >= 0.5 ? 1 : 0);
  return a.flag ? a : comparison(">=", a, number(0.5));
}

void FixedArithmetic::decide(double margin) {
  if (margin > 0) decisions.push_back({path_, margin});
}

}  // namespace tactus
