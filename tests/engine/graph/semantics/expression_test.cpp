#include "engine/graph/semantics/expression.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/graph/semantics/operators.h"
#include "tests/support/error_summary.h"

using namespace tactus;

namespace {

const Source kAt{std::make_shared<const std::string>("a.toml"), 3, 10};

/// The tree in brackets: "(+ x (* 2 y))".
std::string show(const Expression& e) {
  using Op = Expression::Op;
  if (e.op == Op::Signal) return e.name;
  if (e.op == Op::Number) {
    char text[64];
    std::snprintf(text, sizeof text, "%.6g", e.number);
    return std::string{text} + (e.dimension.plain() ? "" : " " + to_string(e.dimension)) +
           (e.bare ? "" : "!");
  }
  std::string text = std::string{"("} + operator_of(e.op).name;
  for (const auto& argument : e.arguments) text += " " + show(argument);
  return text + ")";
}

std::string parsed(std::string_view text) {
  const auto expression = parse_expression(text, kAt);
  return expression ? show(*expression) : test::summary(expression);
}

}  // namespace

TEST_CASE("expression: products bind tighter than sums, both group from the left", "[graph]") {
  CHECK(parsed("x + g * loss") == "(+ x (* g loss))");
  CHECK(parsed("a - b - c") == "(- (- a b) c)");
  CHECK(parsed("a / b * c") == "(* (/ a b) c)");
  CHECK(parsed("(a + b) * c") == "(* (+ a b) c)");
  CHECK(parsed("-a * b") == "(* (- a) b)");
  CHECK(parsed("a - -b") == "(- a (- b))");
  CHECK(parsed("min(a, max(b, 1)) + abs(-c)") == "(+ (min a (max b 1)) (abs (- c)))");
  CHECK(parsed(" \t drum.stick.position ") == "drum.stick.position");
}

TEST_CASE("expression: quantities become SI numbers that know what they measure", "[graph]") {
  CHECK(parsed("15 ms") == "0.015 s!");
  CHECK(parsed("15ms") == "0.015 s!");
  CHECK(parsed("2 N/m") == "2 N/m!");
  CHECK(parsed("5e6 N/m^1.5") == "5e+06 N/m^1.5!");
  CHECK(parsed("3 N s/m * v") == "(* 3 N s/m! v)");
  CHECK(parsed("2 1/m") == "2 1/m!");
  CHECK(parsed("50 % * x") == "(* 0.5! x)");
  CHECK(parsed("0.5 full scale") == "0.5!");
  CHECK(parsed("180 deg") == "3.14159!");
  CHECK(parsed(".5") == "0.5");
}

TEST_CASE("expression: a sign belongs to its decibels", "[graph]") {
  CHECK(parsed("-20 dB") == "0.1!");
  CHECK(parsed("x * -20 dB") == "(* x 0.1!)");
  CHECK(parsed("x - 20 dB") == "(- x 10!)");
  CHECK(parsed("-(20 dB)") == "(- 10!)");
}

TEST_CASE("expression: a unit only stands behind a number, and a spaced '/' or '*' ends it", "[graph]") {
  CHECK(parsed("2 * s") == "(* 2 s)");
  CHECK(parsed("2 s * s") == "(* 2 s! s)");
  CHECK(parsed("1 N / m") == "(/ 1 N! m)");
  CHECK(parsed("1 m/s") == "1 m/s!");
  CHECK(parsed("1 m/speed") == "(/ 1 m! speed)");
  CHECK(parsed("g / 2") == "(/ g 2)");
}

TEST_CASE("expression: comparisons bind least, functions take whole expressions", "[graph]") {
  CHECK(parsed("a + 1 > 2 * b") == "(> (+ a 1) (* 2 b))");
  CHECK(parsed("a<=b") == "(<= a b)");
  CHECK(parsed("a >= -b") == "(>= a (- b))");
  CHECK(parsed("(a == b) * (a != c)") == "(* (== a b) (!= a c))");
  CHECK(parsed("select(a > b, mix(a, b, 0.5), atan2(y, x))") == "(select (> a b) (mix a b 0.5) (atan2 y x))");
}

TEST_CASE("expression: constants are numbers without a unit, and only a bracket makes a name a function",
          "[graph]") {
  CHECK(parsed("2 * pi") == "(* 2 3.14159)");
  CHECK(parsed("e") == "2.71828");
  CHECK(parsed("e.level + pi.low") == "(+ e.level pi.low)");
  CHECK(parsed("mix + mix(mix, exp, 1)") == "(+ mix (mix mix exp 1))");
}

TEST_CASE("expression: every part knows its place, an operator that of its sign", "[graph]") {
  const auto e = parse_expression("x + 2 * abs(-y)", kAt);
  REQUIRE(e);
  CHECK(e->at.text() == "a.toml:3:12");
  CHECK(e->arguments[0].at.column == 10);
  CHECK(e->arguments[1].at.column == 16);
  CHECK(e->arguments[1].arguments[1].at.column == 18);
  CHECK(e->arguments[1].arguments[1].arguments[0].at.column == 22);
  CHECK(e->arguments[1].arguments[1].arguments[0].arguments[0].at.column == 23);
}

TEST_CASE("expression: what cannot be read is said in words", "[graph]") {
  const auto [text, message] = GENERATE(table<std::string, std::string>({
      {"", "a.toml:3:10 Syntax '('"},
      {"x +", "a.toml:3:13 Syntax '('"},
      {"x * / y", "a.toml:3:14 Syntax '/' '('"},
      {"x y", "a.toml:3:12 Syntax 'y'"},
      {"2 ms x", "a.toml:3:15 Syntax 'x'"},
      {"2 x", "a.toml:3:12 Syntax 'x' 2"},
      {"15 msec", "a.toml:3:13 Syntax 'msec'"},
      {"15 furlong", "a.toml:3:13 Syntax 'furlong' 15"},
      {"3 dB/s", "a.toml:3:12 Syntax 'dB/s' 1.5"},
      {"x)", "a.toml:3:11 Syntax ')' '('"},
      {"2 * (x + 1", "a.toml:3:14 Syntax '(' ')'"},
      {"(x y)", "a.toml:3:13 Syntax 'y' ')' ')'"},
      {"1,5", "a.toml:3:11 Syntax ','"},
      {"x ^ 2", "a.toml:3:12 Syntax '^'"},
      {"1.5.2", "a.toml:3:13 Syntax '.2'"},
      {"sqr(x)", "a.toml:3:10 Syntax 'sqr' 'sqrt'"},
      {"min(x)", "a.toml:3:15 Syntax 'min'"},
      {"clamp(x, 1)", "a.toml:3:20 Syntax 'clamp'"},
      {"a < b < c", "a.toml:3:16 Syntax '<'"},
      {"a = b", "a.toml:3:12 Syntax '=' write"},
      {"(a && b)", "a.toml:3:13 Syntax '&&' 0 0"},
      {"x % 2", "a.toml:3:12 Syntax '%'"},
      {"c ? a", "a.toml:3:12 Syntax '?'"},
      {"2pi", "a.toml:3:11 Syntax 'pi' 2"},
      {"min(x, y, z)", "a.toml:3:18 Syntax 'min'"},
      {"abs(x, y)", "a.toml:3:15 Syntax 'abs'"},
      {"max + 1", "a.toml:3:14 Syntax '(' 'max'"},
      {"max(a, b", "a.toml:3:13 Syntax '(' ')'"},
      {"Gain * 2", "a.toml:3:10 Syntax 'Gain'"},
      {"a..b", "a.toml:3:10 Syntax 'a..b'"},
      {"a.", "a.toml:3:10 Syntax 'a.'"},
      {"2 × x", "a.toml:3:12 Syntax '×'"},
      {"1e999", "a.toml:3:10 Syntax 1e999 1e-300 1e300"},
      {"1e5 dB", "a.toml:3:10 Syntax 1e5 1e300"},
  }));
  CHECK(parsed(text) == message);
}

TEST_CASE("expression: depth and length are bounded, so that nothing overflows the stack", "[graph]") {
  const std::string deep(100000, '(');
  CHECK(parsed(deep) == "a.toml:3:74 Syntax 64");
  std::string minuses(100001, '-');
  minuses.back() = 'x';
  CHECK(parsed(minuses).ends_with(" Syntax 64"));
  std::string wide = "x";
  for (int i = 0; i < 999; ++i) wide += "+x";
  CHECK(parse_expression(wide, kAt));
  CHECK(parsed(wide + "+x") == "a.toml:3:2010 Syntax 1000");
}

TEST_CASE("expression: the text of a string begins behind its quote", "[graph]") {
  CHECK(text_start(Value{std::string{"x + y"}, {kAt.file, 2, 5}}).text() == "a.toml:2:6");
}
