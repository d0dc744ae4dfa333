#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/graph/semantics/operators.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"

using namespace tactus;

namespace {

constexpr int kFrames = 300;

/// What an expression of the inputs x and y gives.
test::Samples values_of(const std::string& expression, const test::Samples& x, const test::Samples& y,
                        const std::vector<int>& blocks = {64}) {
  const auto engine = test::engine_of("format = 1\n[inputs]\nx = {}\ny = {}\n[outputs]\nz = { from = \"" +
                                      expression + "\" }\n");
  return test::run(*engine, {x, y}, kFrames, blocks)[0];
}

test::Samples each(const test::Samples& x, const test::Samples& y, double (*f)(double, double)) {
  test::Samples z;
  std::transform(x.begin(), x.end(), y.begin(), std::back_inserter(z), f);
  return z;
}

const test::Samples kX = test::noise(kFrames, 1), kY = test::noise(kFrames, 2);

}  // namespace

TEST_CASE("functions: an expression gives what its functions give, frame by frame", "[runtime]") {
  CHECK(values_of("sin(2 * pi * x)", kX, kY) ==
        each(kX, kY, [](double x, double) { return math::sin(2 * 3.141592653589793 * x); }));
  CHECK(values_of("exp(x) + tanh(y)", kX, kY) ==
        each(kX, kY, [](double x, double y) { return math::exp(x) + math::tanh(y); }));
  CHECK(values_of("x > y", kX, kY) == each(kX, kY, [](double x, double y) { return x > y ? 1.0 : 0.0; }));
  CHECK(values_of("select(x > 0, y, 2 * x)", kX, kY) ==
        each(kX, kY, [](double x, double y) { return x > 0 ? y : 2 * x; }));
  CHECK(values_of("clamp(x, -0.25, abs(y))", kX, kY) ==
        each(kX, kY, [](double x, double y) { return std::max(-0.25, std::min(std::abs(y), x)); }));
  CHECK(values_of("mix(x, y, 0.25)", kX, kY) ==
        each(kX, kY, [](double x, double y) { return x + (y - x) * 0.25; }));
  CHECK(values_of("mod(x, 0.3)", kX, kY) == each(kX, kY, [](double x, double) { return math::mod(x, 0.3); }));
}

TEST_CASE("functions: the size of blocks and loops of one frame change no bit", "[runtime]") {
  for (const auto& type : kOperators) {
    if (!type.is_function()) continue;
    std::string text = std::string{type.name} + "(x";
    for (int i = 1; i < type.operands; ++i) text += i == 1 ? ", y" : ", x + y";
    INFO(text);
    const auto whole = values_of(text + ")", kX, kY, {kFrames});
    CHECK(values_of(text + ")", kX, kY, {1}) == whole);
    CHECK(values_of(text + ")", kX, kY, {3, 64, 17}) == whole);
  }
}

TEST_CASE("functions: lanes in vector registers give the bits of one lane", "[runtime]") {
  for (const auto& type : kOperators) {
    if (!type.is_function() || type.value == nullptr) continue;
    // Inside the domain: after a fault, lanes in one register are silent together.
    const bool positive = type.can_fail && !type.domain.bounded();
    std::string text = std::string{type.name} + (positive ? "(0.1 + abs(low)" : "(low");
    for (int i = 1; i < type.operands; ++i) text += type.can_fail ? ", 0.3" : i == 1 ? ", gain" : ", y";
    INFO(text);
    const auto engine = test::engine_of(
        "format = 1\n[inputs]\nx = {}\ny = {}\n[nodes]\n"
        "gain = { type = \"one_pole\", in = [\"x\", \"0.5 * x\", \"y\", \"x + y\", \"x - y\", \"0.1 * y\", "
        "\"0.2 * x\", \"0.3 * y\"], cutoff = \"1 kHz\" }\n"
        "low = { type = \"one_pole\", in = \"gain\", cutoff = \"2 kHz\" }\n"
        "f = \"" +
        text +
        ")\"\n[outputs]\nlow = { from = \"low\" }\ngain = { from = \"gain\" }\nf = { from = \"f\" }\n");
    const auto& vertices = engine->plan().vertices;
    CHECK(std::ranges::any_of(vertices, [](const Vertex& v) { return v.path == "f[0..7]"; }));
    const auto out = test::run(*engine, {kX, kY}, kFrames, {64});
    for (std::size_t lane = 0; lane < 8; ++lane)
      for (std::size_t n = 0; n < kY.size(); ++n) {
        const double low = out[lane][n], a = positive ? 0.1 + std::abs(low) : low;
        const double b = type.can_fail ? 0.3 : out[8 + lane][n];
        REQUIRE(out[16 + lane][n] == type.value(a, b, kY[n]));
      }
  }
}

TEST_CASE("functions: outside the domain only the bad frames are lost, and counted", "[runtime]") {
  const auto engine = test::engine_of(
      "format = 1\n[inputs]\nx = {}\n[nodes]\nroot = \"sqrt(x)\"\n[outputs]\nz = { from = \"root\" }\n");
  const auto z = test::run(*engine, {kX}, kFrames, {64})[0];
  std::uint64_t negative = 0;
  for (std::size_t n = 0; n < kX.size(); ++n) {
    CHECK(z[n] == (kX[n] < 0 ? 0 : std::sqrt(kX[n])));
    negative += kX[n] < 0 ? 1 : 0;
  }
  const auto faults = engine->faults();
  REQUIRE(faults.size() == 1);
  CHECK(faults.front().path == "root");
  CHECK(static_cast<std::uint64_t>(faults.front().count) == negative);
}

TEST_CASE("functions: of controls at rest they are computed once, and follow when those move", "[runtime]") {
  const auto engine = test::engine_of(
      "format = 1\n[inputs]\nx = {}\n[controls]\nk = { value = 3, range = [-24, 24], smooth = \"0 ms\" }\n"
      "[outputs]\nz = { from = \"x * pow(2, k / 12) + select(k > 4, 1, 0)\" }\n");
  engine->set_journal({{.frame = 100, .kind = JournalEntry::Kind::ControlChange, .index = 0, .value = 12}});
  const auto z = test::run(*engine, {kX}, kFrames, {64})[0];
  CHECK(z[99] == kX[99] * math::pow(2, 0.25));
  CHECK(z[100] == kX[100] * 2 + 1);
}

TEST_CASE("functions: a name of a node that is also a function's stays the node's", "[runtime]") {
  const auto engine = test::engine_of(
      "format = 1\n[inputs]\nx = {}\n[nodes]\nround = \"2 * x\"\n[outputs]\nz = { from = \"round + "
      "round(3.5)\" }\n");
  CHECK(test::run(*engine, {kX}, kFrames, {64})[0][7] == 2 * kX[7] + 4);
}
