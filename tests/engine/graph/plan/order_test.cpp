#include <catch2/catch.hpp>

#include "engine/graph/plan/compile.h"
#include "tests/support/error_summary.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using test::errors_of;

namespace {

std::string graph(const std::string& body) { return "format = 1\nname = \"test\"\n" + body; }

}  // namespace

TEST_CASE("order: two loops without delay are both named", "[graph]") {
  CHECK(errors_of(graph(R"([inputs]
x = {}
[nodes]
a = { type = "clip", in = "x + b" }
b = { type = "clip", in = "a" }
c = { type = "clip", in = "a + d" }
d = { type = "clip", in = "c" }
[outputs]
y = { from = "d" }
)")) == R"(test.toml:6:1 Cycle a -> b -> a 'delay'
test.toml:8:1 Cycle c -> d -> c 'delay')");
}

TEST_CASE("order: what only hangs on a loop without delay is not blamed", "[graph]") {
  CHECK(errors_of(graph(R"([inputs]
x = {}
[nodes]
tail = { type = "clip", in = "a" }
end  = { type = "clip", in = "tail" }
back = { type = "delay", in = "end", time = "2 ms" }
a    = { type = "clip", in = "x + b + back" }
b    = { type = "clip", in = "a" }
[outputs]
y = { from = "end" }
)")) == "test.toml:9:1 Cycle a -> b -> a 'delay'");
}

TEST_CASE("order: names that only name each other are a loop", "[graph]") {
  CHECK(errors_of(graph(R"([nodes]
x = "a"
a = "b"
b = "a"
[outputs]
y = { from = "x" }
)")) == "test.toml:5:1 Cycle a -> b -> a 'delay'");
  CHECK(errors_of(graph("[nodes]\na = \"1 * a\"\n[outputs]\ny = { from = \"a\" }\n")) ==
        "test.toml:4:8 Cycle a -> a 'delay'");
}

TEST_CASE("order: a delay that can be shorter than a frame closes no loop, and the message says so",
          "[graph]") {
  const auto loop = [](const std::string& time) {
    return graph(
        "[inputs]\nx = {}\n[controls]\nt = { value = \"1 ms\", range = [\"0 ms\", \"5 ms\"] }\n"
        "[nodes]\ny = { type = \"delay\", in = \"x + 0.5 * y\", " +
        time + " }\n[outputs]\ny = { from = \"y\" }\n");
  };
  CHECK(errors_of(loop("time = \"t\"")) == "test.toml:8:1 Cycle y -> y 'y' 'min'");
  CHECK(errors_of(loop("time = \"t\", min = \"0.1 ms\"")) == "");
}

TEST_CASE("order: a loop without delay inside a part is named with its path", "[graph]") {
  const test::TemporaryFolder folder;
  folder.write("part.toml", graph(R"([inputs]
in = {}
[nodes]
a = { type = "clip", in = "in + b" }
b = { type = "clip", in = "a" }
[outputs]
out = { from = "b" }
)"));
  const auto spec = load_graph(folder.write("whole.toml", graph(R"([inputs]
x = {}
[nodes]
p = { use = "part.toml", in = "x" }
[outputs]
y = { from = "p.out" }
)")));
  REQUIRE(spec);
  const auto compiled = compile(**spec, standard_nodes(), {});
  REQUIRE_FALSE(compiled);
  CHECK(folder.strip(test::summary(compiled)) == "part.toml:6:1 Cycle p.a -> p.b -> p.a 'delay'");
}

TEST_CASE("order: a network answers a frame later, so that its forces may depend on it", "[graph]") {
  const auto network = [](const std::string& nodes, const std::string& force) {
    return graph(
        "[networks.n]\nm = { type = \"mass\", mass = \"10 g\" }\nf = { type = \"force\", on = \"m\", "
        "force = \"" +
        force + "\" }\n[nodes]\n" + nodes + "[outputs]\nx = { from = \"n.m.position\", unit = \"m\" }\n");
  };
  CHECK(errors_of(network("s = { type = \"spring\", in = \"n.m.position\", stiffness = \"100 N/m\" }\n",
                          "s")) == "");
  // ... but what it drives may be a loop of its own.
  CHECK(errors_of(network("a = \"n.m.position * 1 N/m + b\"\nb = \"0.5 * a\"\n", "b")) ==
        "test.toml:7:27 Cycle a -> b -> a 'delay'");
}
