#include "engine/graph/plan/compile.h"

#include <catch2/catch.hpp>

#include "tests/support/graphs/graph_runner.h"

using namespace tactus;
using test::engine_of;
using test::errors_of;

namespace {

std::string graph(const std::string& body) { return "format = 1\nname = \"test\"\n" + body; }

}  // namespace

TEST_CASE("compile: expressions compute what they say", "[graph]") {
  const auto engine = engine_of(graph(R"(
[inputs]
x = {}
[controls]
k = { value = "-6.0206 dB", range = ["-60 dB", "0 dB"] }
[nodes]
half = "k * x"
sum  = "max(half, 0.25) - min(x, abs(-0.1)) / 2"
[outputs]
y = { from = "sum" }
)"));
  const auto out = test::run(*engine, {{1.0, 0.2, -2.0}}, 3, {2});
  CHECK(out[0][0] == Approx(0.5 - 0.05).epsilon(1e-6));
  CHECK(out[0][1] == Approx(0.25 - 0.05).epsilon(1e-6));
  CHECK(out[0][2] == Approx(0.25 + 1.0).epsilon(1e-6));
}

TEST_CASE("compile: every error of a file in one go, in file order", "[graph]") {
  CHECK(errors_of(graph(R"([inputs]
x = { unit = "m" }
[nodes]
a = { type = "sprign", in = "x" }
b = { type = "spring", in = "x", stiffnes = "100 N/m" }
c = { type = "clip", in = "y" }
d = "x + 3 N"
k = "a * 2"
f = { type = "spring", in = "3 V", stiffness = "-1 N/m" }
[outputs]
force = { from = "f" }
)")) == R"(test.toml:6:14 UnknownName 'sprign' 'spring'
test.toml:7:1 Missing 'b' 'stiffness' stiffness
test.toml:7:34 UnknownName 'b' 'stiffnes' 'stiffness'
test.toml:8:28 UnknownName 'y'
test.toml:9:10 UnitMismatch
test.toml:11:30 UnitMismatch 'in' 'f'
test.toml:11:49 OutOfRange 'stiffness' 'f' -1 0
test.toml:13:1 UnitMismatch 'force' unit "N")");
}

TEST_CASE("compile: what reaches no output is left out", "[graph]") {
  const auto engine = engine_of(graph(R"(
[inputs]
x = {}
unused = {}
[controls]
nobody = { value = 0.5 }
[nodes]
lost  = { type = "clip", in = "x" }
muted = { type = "clip", in = "x" }
two   = "1 + 1"
[outputs]
y = { from = "two * x + 0 * muted" }
)"));
  std::map<std::string, std::string> reasons;
  for (const auto& left : engine->plan().left_out) reasons[left.path] = left.reason;
  CHECK(reasons["lost"] == "reaches no output");
  CHECK(reasons["unused"] == "reaches no output");
  CHECK(reasons["muted"] == "reaches only signals that are multiplied by zero");
  CHECK(reasons["nobody"] == "its output is not used");
  CHECK(reasons["two"] == "is always 2");
  CHECK(engine->plan().nodes.empty());
}

TEST_CASE("compile: a loop without delay is named edge by edge", "[graph]") {
  CHECK(errors_of(graph(R"([inputs]
x = {}
[nodes]
a = { type = "clip", in = "x + b" }
b = "0.5 * c"
c = { type = "clip", in = "a" }
[outputs]
y = { from = "a" }
)")) == "test.toml:6:1 Cycle a -> c -> b -> a 'delay'");
}

TEST_CASE("compile: lanes repeat, run side by side, and need a mix to meet", "[graph]") {
  const auto engine = engine_of(graph(R"(
[inputs]
x = { lanes = 2 }
[nodes]
gains = "x * 10"
many  = { type = "clip", in = "gains", high = [3, 4] }
sum   = { type = "mix", in = "many" }
ramp  = { type = "clip", voices = 3, in = { from = 0.1, to = 0.3 } }
all   = { type = "mix", in = "ramp" }
[outputs]
each = { from = "many" }
one  = { from = "sum" }
six  = { from = "all" }
)"));
  const auto out = test::run(*engine, {{1.0}, {0.35}}, 1, {1});
  REQUIRE(out.size() == 4);
  CHECK(out[0][0] == 3);
  CHECK(out[1][0] == 3.5);
  CHECK(out[2][0] == 6.5);
  CHECK(out[3][0] == Approx(0.6));
  CHECK(errors_of(graph(R"([inputs]
x = { lanes = 2 }
[nodes]
bad = "x + y"
y   = { type = "clip", in = [1, 2, 3] }
[outputs]
z = { from = "bad" }
)")) == "test.toml:6:8 OutOfRange 2 3 'mix'");
}
