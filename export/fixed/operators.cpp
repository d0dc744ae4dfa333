#include "export/fixed/operators.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tactus {
namespace {

using Op = Expression::Op;
using Values = std::span<const FixedValue>;

template <FixedValue (FixedArithmetic::*Of)(const FixedValue&, const FixedValue&, bool) const>
FixedValue of_two(FixedArithmetic& a, Values in, bool wide) {
  return (a.*Of)(in[0], in[1], wide);
}

template <std::size_t Length>
struct SignText {
  char text[Length];
  constexpr SignText(const char (&given)[Length]) { std::copy_n(given, Length, text); }
};
template <SignText kSign>
FixedValue comparison(FixedArithmetic& a, Values in, bool) {
  return a.comparison(kSign.text, in[0], in[1]);
}
template <SignText kHow>
FixedValue whole(FixedArithmetic& a, Values in, bool) {
  return a.whole(kHow.text, in[0]);
}

constexpr auto kFixedOperators = std::to_array<FixedOperator>({
    {Op::Signal, [](FixedArithmetic& a, Values in, bool wide) { return wide ? in[0] : a.word(in[0]); }},
    {Op::Negate,
     [](FixedArithmetic& a, Values in, bool wide) { return a.negative(wide ? in[0] : a.word(in[0])); }},
    {Op::Add, of_two<&FixedArithmetic::sum>},
    {Op::Subtract, of_two<&FixedArithmetic::difference>},
    {Op::Multiply, of_two<&FixedArithmetic::product>},
    {Op::Divide,
     [](FixedArithmetic& a, Values in, bool wide) {
       return in[1].constant && *in[1].constant != 0 && !in[0].constant
                  ? a.product(in[0], a.number(1 / *in[1].constant), wide)
                  : a.quotient(in[0], in[1]);
     }},
    {Op::Less, comparison<"<">},
    {Op::LessOrEqual, comparison<"<=">},
    {Op::Greater, comparison<">">},
    {Op::GreaterOrEqual, comparison<">=">},
    {Op::Equal, comparison<"==">},
    {Op::NotEqual, comparison<"!=">},
    {Op::Min, of_two<&FixedArithmetic::smaller>},
    {Op::Max, of_two<&FixedArithmetic::larger>},
    {Op::Abs, [](FixedArithmetic& a, Values in, bool) { return a.size(in[0]); }},
    {Op::Sign, [](FixedArithmetic& a, Values in, bool) { return a.sign(in[0]); }},
    {Op::Floor, whole<"floor">},
    {Op::Ceil, whole<"ceil">},
    {Op::Round, whole<"round">},
    {Op::Select,
     [](FixedArithmetic& a, Values in, bool wide) { return a.choice(in[0], in[1], in[2], wide); }},
});

/// Largest distance of the lines between the points from the function, where it can be read.
double distance_from_lines(const std::function<double(double)>& f, double first, double distance, int lines,
                           double last) {
  double largest = 0;
  for (int i = 0; i < lines; ++i) {
    const double x0 = first + i * distance, y0 = f(x0), y1 = f(x0 + distance);
    for (int k = 1; k < 16; ++k) {
      const double t = k / 16.0, x = x0 + t * distance;
      if (x <= last) largest = std::max(largest, std::abs(f(x) - (y0 + t * (y1 - y0))));
    }
  }
  return 1.1 * largest;
}

}  // namespace

const FixedOperator* find_fixed_operator(Op op) {
  const auto found = std::ranges::find(kFixedOperators, op, &FixedOperator::op);
  return found == kFixedOperators.end() ? nullptr : &*found;
}

FixedValue tabulated(const FixedArithmetic& arithmetic, const std::function<double(double)>& function,
                     const FixedValue& given, const MakeTable& table) {
  const auto x = arithmetic.word(given);
  const double step = x.step();
  const double first = std::floor(x.range.low / step), last = std::ceil(x.range.high / step);
  const int most_lines = arithmetic.bits() == 16 ? 1024 : 2048;
  const double finest = std::ldexp(0.5, -(arithmetic.bits() - 1));
  int by = arithmetic.bits() - 4, lines = 0;
  double off = 0, highest = 0, lowest = 0, steepest = 0;
  for (;; --by) {
    lines = static_cast<int>((last - first) / std::ldexp(1.0, by)) + 1;
    off = distance_from_lines(function, first * step, std::ldexp(step, by), lines, last * step);
    double size = 1e-300;
    for (int i = 0; i <= lines; ++i)
      size = std::max(size, std::abs(function((first + i * std::ldexp(1.0, by)) * step)));
    if (off <= finest * size || 2 * lines > most_lines || by <= 1) break;
  }
  std::vector<double> points;
  for (int i = 0; i <= lines; ++i) points.push_back(function((first + i * std::ldexp(1.0, by)) * step));
  for (std::size_t i = 0; i < points.size(); ++i) {
    lowest = i == 0 ? points[0] : std::min(lowest, points[i]);
    highest = i == 0 ? points[0] : std::max(highest, points[i]);
    if (i > 0) steepest = std::max(steepest, std::abs(points[i] - points[i - 1]) / std::ldexp(step, by));
  }
  const Interval range{lowest, highest};
  int exponent = arithmetic.fitting(range);
  while (std::ldexp(std::max(2 * steepest * std::ldexp(step, by), range.high - range.low), exponent) >=
             std::ldexp(1.0, arithmetic.bits()) - 2 ||
         arithmetic.fitting(widened_by(range, std::ldexp(1.0, -exponent))) < exponent)
    --exponent;
  std::vector<std::string> numbers;
  for (const double point : points) numbers.push_back(arithmetic.literal(point, exponent));
  const auto start = arithmetic.literal(first * step, x.exponent);
  const double rounding = std::ldexp(1.0, -exponent);
  return {fmt::format("tactus_interpolated({}, (tactus_uword)((tactus_uword){} - (tactus_uword){}), {})",
                      table(numbers), x.text, start.front() == '-' ? "(" + start + ")" : start, by),
          exponent, widened_by(range, rounding), off + rounding + steepest * x.error};
}

}  // namespace tactus
