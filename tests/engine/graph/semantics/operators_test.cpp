#include "engine/graph/semantics/operators.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/support/graphs/graph_runner.h"

using namespace tactus;
using test::errors_of;

namespace {

/// Of one expression in column 15 of line 9, beside inputs in m, N and 1.
std::string error_of(const std::string& expression) {
  return errors_of(
      "format = 1\n[inputs]\nx = { unit = \"m\" }\nf = { unit = \"N\" }\np = {}\n[controls]\n"
      "k = { value = 0.5, range = [0, 1] }\n[outputs]\n"
      "z = { from = \"" +
      expression + "\", unit = \"m\" }\n");
}

Interval range_of(const char* name, Interval a, Interval b = {}, Interval c = {}) {
  return tactus::range_of(*find_function(name), {a, b, c});
}

}  // namespace

TEST_CASE("operators: units go through functions as their rules say", "[graph]") {
  for (const auto* right :
       {"sqrt(x * x)", "sqrt(pow(x, 2))", "pow(x, 3) / pow(x, 2)", "1 m * pow(2, p)", "clamp(x, -1 m, 0.5)",
        "mix(x, 2 mm, p)", "select(f > 2 N, x, 3 mm)", "mod(x, 1 mm)", "1 m * sin(90 deg)",
        "1 m * atan2(x, 2 m)", "x * sign(f)", "round(x / 1 mm) * 1 mm", "1 m * exp(p)", "x * (f <= 2)",
        "min(x, 3 mm) + abs(x)", "pow(x, 2 - 1)"})
    CHECK(error_of(right) == "");
}

TEST_CASE("operators: units that do not fit are reported where they are", "[graph]") {
  const auto [expression, error] = GENERATE(table<std::string, std::string>({
      {"1 m * exp(f)", "test.toml:9:25 UnitMismatch 'exp'"},
      {"floor(x)", "test.toml:9:21 UnitMismatch 'floor'\ntest.toml:9:1 UnitMismatch 'z' 'from' 'unit'"},
      {"sqrt(x) * sqrt(x)", "test.toml:9:20 UnitMismatch 'sqrt'\ntest.toml:9:30 UnitMismatch 'sqrt'"},
      {"pow(x, p)", "test.toml:9:22 UnitMismatch 'pow'"},
      {"pow(x, 0.5)", "test.toml:9:22 UnitMismatch 'pow'"},
      {"1 m * pow(2, x)", "test.toml:9:28 UnitMismatch 'pow'"},
      {"1 m * atan2(x, f)", "test.toml:9:30 UnitMismatch 'atan2'"},
      {"1 m * (x > f)", "test.toml:9:26 UnitMismatch"},
      {"select(x, x, x)", "test.toml:9:22 UnitMismatch 'select'"},
      {"select(p, x, f)", "test.toml:9:28 UnitMismatch 'select'"},
      {"mix(x, f, 1)", "test.toml:9:22 UnitMismatch 'mix'"},
      {"mix(x, x, x)", "test.toml:9:25 UnitMismatch 'mix'"},
  }));
  INFO(expression);
  const auto found = error_of(expression);
  // The output's own unit may be wrong in consequence.
  CHECK(found.find(error.substr(0, error.find('\n'))) != std::string::npos);
}

TEST_CASE("operators: a constant outside a domain is an error with place and remedy", "[graph]") {
  CHECK(error_of("1 m * sqrt(-2)") == "test.toml:9:21 OutOfRange 0 -2");
  CHECK(error_of("1 m * log(0)") == "test.toml:9:21 OutOfRange 0 0");
  CHECK(error_of("1 m * asin(1 + k + 0.5)") == "test.toml:9:21 OutOfRange -1 1");
  CHECK(error_of("mod(x, 0)") == "test.toml:9:15 OutOfRange 0");
  CHECK(error_of("1 m * pow(-2, 0.5)").starts_with("test.toml:9:21 OutOfRange"));
  CHECK(error_of("1 m * exp(1000)").starts_with("test.toml:9:19 OutOfRange"));
  CHECK(error_of("1 m * log(k)") == "");  // a control may reach the end of a domain, which is then a fault
}

TEST_CASE("operators: constants of expressions name nothing that expressions see", "[graph]") {
  CHECK(errors_of("format = 1\n[inputs]\ne = {}\n[nodes]\npi = \"2 * e\"\n") ==
        "test.toml:3:1 Syntax 'e'\ntest.toml:5:1 Syntax 'pi'");
  CHECK(errors_of("format = 1\n[inputs]\nx = {}\n[outputs]\ne = { from = \"x\" }\n") == "");
  CHECK(errors_of("format = 1\n[inputs]\nx = {}\n[outputs]\nz = { from = \"x + sqrt\" }\n") ==
        "test.toml:5:19 UnknownName 'sqrt'");
}

TEST_CASE("operators: ranges hold all values inside them, and 0 where a fault is possible", "[graph]") {
  std::mt19937_64 bits{1};
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(bits() >> 11) * 0x1p-53;
  };
  for (const auto& type : kOperators) {
    if (type.value == nullptr) continue;
    for (int i = 0; i < 300; ++i) {
      OperandRanges in{};
      for (auto& range : in) {
        const double a = uniform(-4, 4), b = uniform(-4, 4);
        range = i % 5 == 0 ? Interval::exactly(std::round(a)) : Interval{std::min(a, b), std::max(a, b)};
      }
      const auto range = tactus::range_of(type, in);
      for (int k = 0; k < 20; ++k) {
        OperandValues at{};
        for (std::size_t o = 0; o < at.size(); ++o) at[o] = uniform(in[o].low, in[o].high);
        double value = type.value(at[0], at[1], at[2]);
        if (!std::isfinite(value)) value = 0;  // what a fault gives
        INFO(type.name << " of " << at[0] << ", " << at[1] << ", " << at[2] << " = " << value);
        CHECK(range.contains(value));
      }
    }
  }
}

TEST_CASE("operators: ranges of functions are those of their ends", "[graph]") {
  CHECK(range_of("sin", {-10, 10}).high == 1);
  CHECK(range_of("exp", {0, 1}).high == Approx(math::exp(1)));
  CHECK(range_of("sqrt", {4, 9}).low == Approx(2));
  CHECK(range_of("sqrt", {-4, 9}).low == 0);
  CHECK(range_of("acos", {0, 1}).high == Approx(0.5 * kPi));
  CHECK(range_of("mod", {-5, 5}, Interval::exactly(2)).high == 2);
  CHECK(range_of("mix", {1, 2}, {3, 4}, {0, 1}).low == Approx(1));
  CHECK(range_of("clamp", {}, Interval::exactly(-1), Interval::exactly(3)).high == 3);
  CHECK(range_of("pow", {-3, 2}, Interval::exactly(2)).high == Approx(9));
  CHECK(range_of("log", {}).low == -kUnlimited);
}

TEST_CASE("operators: the documentation has a line for every function", "[docs]") {
  std::ifstream in{std::filesystem::path{TACTUS_SOURCE_DIR} / "docs/graph_files.md"};
  const std::string text{std::istreambuf_iterator<char>{in}, {}};
  for (const auto& type : kOperators) {
    if (!type.is_function()) continue;
    INFO(type.use());
    CHECK(text.find("| `" + type.use() + "` |") != std::string::npos);
  }
}
