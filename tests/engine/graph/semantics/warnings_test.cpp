#include <catch2/catch.hpp>
#include <set>

#include "engine/nodes/other_names.h"
#include "tests/support/graphs/graph_runner.h"

using namespace tactus;

namespace {

std::string warnings_of(const std::string& text) {
  const auto plan = compile(parse_graph_leniently(text, "test.toml"), standard_nodes(), {});
  return test::full_text(plan ? (*plan)->warnings : plan.error());
}

const std::string kGraph =
    "format = 1\n[inputs]\nx = {}\n[controls]\ngain = { value = 1, range = [0, 2] }\n[nodes]\n"
    "hit = { type = \"threshold\", in = \"x\", level = 0.5 }\n";

}  // namespace

TEST_CASE("warnings: a number without a unit where one is expected is named with what it counts as",
          "[graph]") {
  const auto with = [](const std::string& time) {
    return warnings_of(kGraph + "pulse = { type = \"decay\", trigger = \"hit\", time = " + time +
                       " }\n[outputs]\nout = { from = \"gain * pulse\" }\n");
  };
  CHECK(with("6") ==
        "test.toml:8:51: 'time' of decay 'pulse' has no unit: it counts as 6 s; write \"6 s\", or the unit "
        "that is meant");
  CHECK(with("\"6\"").find("counts as 6 s") != std::string::npos);
  CHECK(with("[1, \"2 ms\"]").find("counts as 1 s") != std::string::npos);
  CHECK(with("\"6 ms\"") == "");
  CHECK(with("\"gain * 6 ms\"") == "");
  CHECK(with("0") == "");
}

TEST_CASE("warnings: what nothing uses is named", "[graph]") {
  CHECK(warnings_of(kGraph + "a = \"2 * x\"\nb = { type = \"slew\", in = \"a\", rise = 1, fall = 1 }\n"
                             "[outputs]\nout = { from = \"x\" }\n") ==
        "test.toml:5:1: control 'gain' is not used; use it in a node or an output, or remove it\n"
        "test.toml:9:1: node 'b' is not used; connect it to an output, or remove it");
  CHECK(warnings_of("format = 1\n[inputs]\nx = {}\n[outputs]\nout = { from = 0.5 }\n") ==
        "test.toml:3:1: input 'x' is not used; use it in a node or an output, or remove it");
  // A trigger is an event, which is recorded.
  CHECK(warnings_of(kGraph + "[outputs]\nout = { from = \"gain * x\" }\n") == "");
}

TEST_CASE("warnings: names that other programs have for nodes lead to ours", "[graph]") {
  std::set<std::string_view> names;
  for (const auto& other : other_names()) {
    INFO(other.name);
    CHECK(names.insert(other.name).second);
    CHECK(standard_nodes().find(other.name) == nullptr);
    CHECK((!other.types.empty() || !other.remedy.empty()));
    std::string types{other.types};
    for (auto end = types.find(' '); !types.empty(); end = types.find(' ')) {
      CHECK(standard_nodes().find(types.substr(0, end)) != nullptr);
      types = end == std::string::npos ? "" : types.substr(end + 1);
    }
  }
  const auto error = [](const std::string& type) {
    return test::full_errors_of("format = 1\n[nodes]\nx = { type = \"" + type + "\" }\n");
  };
  CHECK(
      error("metro~") ==
      "test.toml:3:14: there is no node type 'metro~'; use clock: { type = \"clock\", tempo = \"120 bpm\" }");
  CHECK(error("LPF.ar") == "test.toml:3:14: there is no node type 'LPF.ar'; use low_pass");
  CHECK(error("biquad").find("use low_pass, high_pass or band_pass") != std::string::npos);
  CHECK(error("EnvGen.kr").find("use adsr, decay or curve") != std::string::npos);
  CHECK(error("onsett").find("did you mean 'onset'?") != std::string::npos);
}
