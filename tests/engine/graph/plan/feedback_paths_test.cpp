#include <catch2/catch.hpp>

#include "engine/graph/plan/compile.h"
#include "engine/scene/guard_report.h"
#include "tests/support/graphs/graph_runner.h"

using namespace tactus;

namespace {

/// The path to the output `y` of a graph: "", "input", "loop" or "input loop".
std::string path_of(const std::string& body) {
  const auto engine = test::engine_of("format = 1\nname = \"test\"\n" + body);
  const auto path = guarded_channels(engine->plan(), {}).front().feedback;
  std::string text = path.from_input ? "input" : "";
  if (path.internal_loop) text += text.empty() ? "loop" : " loop";
  return text;
}

}  // namespace

TEST_CASE("feedback paths: none from a generator, whatever the controls and other outputs do", "[graph]") {
  CHECK(path_of(R"GRAPH(
[inputs]
x = {}
[controls]
level = { value = 0.5 }
[nodes]
tone = { type = "sine", level = "level", frequency = "400 Hz" }
[outputs]
y     = { from = "abs(tone)" }
other = { from = "x" }
)GRAPH")
            .empty());
}

TEST_CASE("feedback paths: from an input, through nodes and expressions, to drives and sound", "[graph]") {
  const std::string kind = GENERATE("drive", "audio");
  const std::string output = R"TEXT(y = { from = "max(0.1, 2 * ring)", kind = ")TEXT" + kind + "\" }\n";
  CHECK(path_of(R"GRAPH(
[inputs]
x = {}
[nodes]
hit  = { type = "threshold", in = "x", level = 0.5 }
ring = { type = "decay", trigger = "hit", time = "10 ms" }
[outputs]
)GRAPH" + output) == "input");
}

TEST_CASE("feedback paths: a control at zero does not cut a path, a constant zero does", "[graph]") {
  const auto with = [](const std::string& gain) {
    return path_of(R"GRAPH(
[inputs]
x = {}
[controls]
level = { value = 0 }
[nodes]
tone = { type = "sine", level = 0.5, frequency = "400 Hz" }
[outputs]
y = { from = "tone + )GRAPH" +
                   gain + R"GRAPH( * x" }
)GRAPH");
  };
  CHECK(with("level") == "input");
  CHECK(with("0").empty());
}

TEST_CASE("feedback paths: a loop counts where it reaches the output", "[graph]") {
  const auto with = [](const std::string& from) {
    return path_of(R"GRAPH(
[nodes]
tick = { type = "sine", level = 0.1, frequency = "4 Hz" }
sum  = "tick + 0.9 * echo"
echo = { type = "delay", in = "sum", time = "100 ms" }
[outputs]
y    = { from = ")GRAPH" +
                   from + R"GRAPH(" }
z    = { from = "echo" }
)GRAPH");
  };
  CHECK(with("0.5 * sum") == "loop");
  CHECK(with("tick").empty());
}

TEST_CASE("feedback paths: a network is a loop", "[graph]") {
  CHECK(path_of(R"GRAPH(
[networks.body]
frame = { type = "ground" }
m     = { type = "mass", mass = "10 g" }
s     = { type = "spring", between = ["frame", "m"], stiffness = "100 N/m" }
push  = { type = "force", on = "m", force = "1 N" }
[outputs]
y = { from = "body.m.position / 1 m" }
)GRAPH") == "loop");
}
