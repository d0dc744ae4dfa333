#include <catch2/catch.hpp>

#include "tests/support/error_summary.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using test::TemporaryFolder;

namespace {

/// The value of each lane of output `y`, for an input x of 1.
std::vector<double> lanes_of(const std::string& nodes) {
  const auto engine = test::engine_of("format = 1\n[inputs]\nx = {}\n[nodes]\n" + nodes +
                                      "[outputs]\ny = { from = \"y\" }\n");
  std::vector<double> lanes;
  for (const auto& channel : test::run(*engine, {{1.0}}, 1, {1})) lanes.push_back(channel[0]);
  return lanes;
}

std::string node_errors(const std::string& nodes) {
  return test::errors_of("format = 1\n[inputs]\nx = {}\n[nodes]\n" + nodes +
                         "[outputs]\ny = { from = \"y\" }\n");
}

/// A part that gives `gain * x` and, as `all`, the mix of it over its voices.
constexpr auto kPart = R"(format = 1
[inputs]
x = {}
[controls]
gain = { value = 5 , range = [0, 10] }
[nodes]
kept = { type = "clip", in = "gain * x", low = -100, high = 100 }
once = { type = "mix", in = "x" }
sum  = { type = "mix", in = "kept" }
[outputs]
each = { from = "kept" }
once = { from = "once" }
all  = { from = "sum" }
)";

std::vector<double> lanes_of_part(const std::string& fields, const std::string& from) {
  const TemporaryFolder folder;
  folder.write("part.toml", kPart);
  const auto file =
      folder.write("a.toml", "format = 1\n[inputs]\nx = {}\n[nodes]\np = { use = \"part.toml\", x = \"x\"" +
                                 fields + " }\n[outputs]\ny = { from = \"" + from + "\" }\n");
  auto compiled = compile(load_graph_leniently(file), standard_nodes(), {});
  if (!compiled) throw std::runtime_error(to_string(compiled.error()));
  Player engine{std::move(*compiled)};
  std::vector<double> lanes;
  for (const auto& channel : test::run(engine, {{1.0}}, 1, {1})) lanes.push_back(channel[0]);
  return lanes;
}

using Lanes = std::vector<double>;

}  // namespace

TEST_CASE("voices: a node has as many lanes as it asks for, one lane repeats for all", "[graph]") {
  CHECK(lanes_of("y = { type = \"clip\", in = \"x\", voices = 3 }\n") == Lanes{1, 1, 1});
  CHECK(lanes_of("y = { type = \"clip\", in = \"x\", high = [0.1, 0.2] }\n") == Lanes{0.1, 0.2});
  CHECK(lanes_of("a = [1, 2]\nb = [3, 4]\ny = \"x * a * b\"\n") == Lanes{3, 8});
}

TEST_CASE("voices: a spread goes from end to end, in equal steps or equal ratios", "[graph]") {
  const auto spread = [](const std::string& curve) {
    return lanes_of("y = { type = \"clip\", in = 100, voices = 3, high = { from = 1, to = 4" + curve +
                    " } }\n");
  };
  CHECK(spread("") == Lanes{1, 2.5, 4});
  CHECK(spread(", curve = \"linear\"") == Lanes{1, 2.5, 4});
  CHECK(spread(", curve = \"exponential\"") == Lanes{1, 2, 4});
}

TEST_CASE("voices: a part has as many lanes as it asks for, with parameters of their own", "[graph]") {
  CHECK(lanes_of_part("", "p.each") == Lanes{5});
  CHECK(lanes_of_part(", voices = 3", "p.each") == Lanes{5, 5, 5});
  CHECK(lanes_of_part(", voices = 3, gain = [1, 2, 3]", "p.each") == Lanes{1, 2, 3});
  CHECK(lanes_of_part(", voices = 3, gain = { from = 1, to = 4, curve = \"exponential\" }", "p.each") ==
        Lanes{1, 2, 4});
  CHECK(lanes_of_part(", voices = 3, gain = { from = 1, to = 4 }", "p.all") == Lanes{7.5});
  CHECK(lanes_of_part(", gain = [1, 2]", "p.each") == Lanes{1, 2});
}

TEST_CASE("voices: a mix adds the lanes that there are, in a part with voices too", "[graph]") {
  CHECK(lanes_of("a = [1, 2, 3]\ny = { type = \"mix\", in = \"x * a\" }\n") == Lanes{6});
  CHECK(lanes_of("y = { type = \"mix\", in = \"x\" }\n") == Lanes{1});
  CHECK(lanes_of_part(", voices = 4", "p.once") == Lanes{1});
}

TEST_CASE("voices: several lanes into one, or into another number, need a mix", "[graph]") {
  CHECK(node_errors("a = [1, 2]\nb = [1, 2, 3]\ny = \"x * a + b\"\n") ==
        "test.toml:7:8 OutOfRange 2 3 'mix'");
  CHECK(node_errors("a = [1, 2]\nb = [1, 2, 3]\ny = { type = \"mix\", in = \"a + b\" }\n") ==
        "test.toml:7:27 OutOfRange 2 3 'mix'");
  CHECK(node_errors("a = [1, 2]\ny = { type = \"clip\", in = [\"x\", \"a\"] }\n") ==
        "test.toml:6:34 OutOfRange 2 'mix'");
}
