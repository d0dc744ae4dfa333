#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <set>

#include "engine/graph/semantics/operators.h"
#include "tests/conformance/node_cases.h"
#include "tests/conformance/random_graph.h"
#include "tests/export/compiled_programs.h"

// Every type of node, operator and random graph: exported, compiled as C99 and run, with the bits of the
// engine.

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr int kFrames = 6000;  // `stroke` detects nothing in its first 100 ms

/// To the last bit.
std::string exactly(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

/// All cases of a type as one graph; every port of each that is a signal is an input, and every output from
/// `first_output` on is one of the graph.
struct CaseGraph {
  std::string text;
  Channels inputs;
};

std::string unit_text(const InputPort& port) {
  if (port.unit == "=in/s") return " Hz";
  return port.unit.empty() || port.unit == "any" || port.unit[0] == '=' ? "" : " " + port.unit;
}

std::string port_text(const InputPort& port, const InputValue& value, const std::string& input,
                      CaseGraph& graph, std::string& declared) {
  const auto unit = unit_text(port);
  if (const auto* constant = std::get_if<double>(&value)) return "\"" + exactly(*constant) + unit + "\"";
  const auto range = typical_range(port);
  declared += input + " = {}\n";
  graph.inputs.push_back(std::get<Samples>(value));
  const auto limited = "max(" + exactly(range.low) + ", min(" + exactly(range.high) + ", " + input + "))";
  return "\"" + limited + (unit.empty() ? "" : " * 1" + unit) + "\"";
}

CaseGraph graph_of(const NodeType& type, std::size_t first_output = 0) {
  CaseGraph graph;
  std::string declared, nodes, outputs;
  int number = 0;
  for (const auto& one : ordinary_cases(type, kFrames, 2)) {
    const auto name = "c" + std::to_string(number++);
    nodes += name + " = { type = \"" + type.name + "\"";
    for (const auto& port : type.inputs)
      nodes += ", " + port.name + " = " +
               port_text(port, one.inputs.at(port.name), name + "_" + port.name, graph, declared);
    for (const auto& setting : type.settings)
      if (const auto given = one.settings.find(setting.name); given != one.settings.end())
        nodes += ", " + setting.name + " = " + as_written(setting, given->second);
    nodes += " }\n";
    for (std::size_t k = first_output; k < type.outputs.size(); ++k) {
      const auto& output = type.outputs[k];
      outputs += name + "_" + output.name + " = { from = \"" +
                 plain_signal(name + "." + output.name, output.unit) + "\" }\n";
    }
  }
  graph.text = "format = 1\nname = \"node " + type.name + "\"\n[inputs]\n" + declared + "[nodes]\n" + nodes +
               "[outputs]\n" + outputs;
  return graph;
}

/// Of all outputs of both: the largest difference, as a share of the largest value.
double relative_error(const Channels& a, const Channels& b) {
  double worst = 0;
  for (std::size_t c = 0; c < a.size(); ++c) {
    double size = 0, error = 0;
    for (std::size_t n = 0; n < a[c].size(); ++n) {
      size = std::max(size, std::abs(a[c][n]));
      error = std::max(error, std::abs(a[c][n] - b[c][n]));
    }
    if (error > 0) worst = std::max(worst, error / size);
  }
  return worst;
}

}  // namespace

TEST_CASE("export: every type of node gives the bits of the engine", "[export]") {
  const TemporaryFolder folder;
  copy_files(folder);
  const auto file = (folder.path() / "test.toml").string();
  CompiledPrograms programs;
  std::map<std::string, CaseGraph> graphs;
  for (const auto* type : standard_nodes().types) {
    INFO(type->name);
    graphs[type->name] = graph_of(*type);
    REQUIRE(programs.add(graphs[type->name].text, exact_options(), file) == "");
  }
  programs.compile();
  for (const auto* type : standard_nodes().types) {
    INFO(type->name);
    const auto& graph = graphs[type->name];
    auto engine = engine_for(parse_graph_leniently(graph.text, file), exact_options());
    const auto expected = run(engine, graph.inputs, kFrames, {64});
    CHECK(first_difference(programs.run("node_" + type->name, graph.inputs, kFrames), expected) == "");
    CHECK(std::any_of(expected.begin(), expected.end(), [](const Samples& channel) {
      return std::any_of(channel.begin(), channel.end(), [](double x) { return x != 0; });
    }));
  }
}

TEST_CASE("export: a signal that each node reads twice takes no time for each path to it", "[export]") {
  std::string nodes = "n0 = \"0.5 * x\"\n";
  constexpr int kNodes = 200;  // 2^199 paths
  for (int n = 1; n < kNodes; ++n)
    nodes += fmt::format("n{0} = \"0.4 * n{1} + 0.5 * n{1} * n{1}\"\n", n, n - 1);
  CompiledPrograms programs;
  CHECK(
      programs.add(fmt::format("format = 1\nname = \"deep\"\n[inputs]\nx = {{ range = [-1, 1] }}\n[nodes]\n{}"
                               "[outputs]\ny = {{ from = \"n{}\" }}\n",
                               nodes, kNodes - 1),
                   exact_options()) == "");
}

TEST_CASE("export: a node of which one output is read compiles without a warning", "[export]") {
  const TemporaryFolder folder;
  copy_files(folder);
  const auto file = (folder.path() / "test.toml").string();
  CompiledPrograms programs;
  for (const auto* type : standard_nodes().types) {
    if (type->outputs.size() < 2) continue;
    INFO(type->name);
    REQUIRE(programs.add(graph_of(*type, type->outputs.size() - 1).text, exact_options(), file) == "");
  }
  CHECK_NOTHROW(programs.compile());
}

TEST_CASE("export: every operator gives the bits of the engine, and 0 outside its domain", "[export]") {
  std::string outputs;
  int number = 0;
  const auto add = [&](const std::string& expression) {
    outputs += "y" + std::to_string(number++) + " = { from = \"" + expression + "\" }\n";
  };
  for (const char* sign : {"+", "-", "*", "/", "<", "<=", ">", ">=", "==", "!="})
    add(std::string{"x "} + sign + " y");
  for (const auto& type : kOperators)
    if (type.is_function())
      add(std::string{type.name} + (type.operands == 1   ? "(x)"
                                    : type.operands == 2 ? "(x, y)"
                                                         : "(x, y, z)"));
  add("-x");
  add("x - (y - z)");
  add("x / 3 / (y * z)");
  add("-(x + y) * -z");
  const auto text =
      "format = 1\nname = \"operators\"\n[inputs]\nx = {}\ny = {}\nz = {}\n[outputs]\n" + outputs;
  Channels in{noise(kFrames, 1, -30, 30), noise(kFrames, 2, -3, 3), noise(kFrames, 3, -1, 1)};
  // Where operators change: whole numbers, equal numbers, zeros of both signs.
  for (std::size_t n = 0; n < in[0].size(); n += 3) in[0][n] = std::round(in[0][n] / 10);
  for (std::size_t n = 0; n < in[1].size(); n += 5) in[1][n] = std::round(in[1][n]);
  for (std::size_t n = 0; n < in[2].size(); n += 7) in[2][n] = n % 2 == 0 ? 0.0 : -0.0;
  CompiledPrograms programs;
  REQUIRE(programs.add(text, exact_options()) == "");
  programs.compile();
  auto engine = engine_for(parse_graph_leniently(text, "test.toml"), exact_options());
  CHECK(first_difference(programs.run("operators", in, kFrames), run(engine, in, kFrames, {64})) == "");
}

TEST_CASE("export: random graphs give the bits of the engine while controls move", "[export]") {
  const TemporaryFolder folder;
  copy_files(folder);
  const auto file = (folder.path() / "test.toml").string();
  CompiledPrograms programs;
  std::map<unsigned, std::string> texts;
  for (unsigned seed = 1; texts.size() < 25; ++seed) {
    const int lanes = 2 + static_cast<int>(seed % 3);
    folder.write("part.toml", RandomGraph{1000000, 2}.text(true));
    const auto text =
        "name = \"random " + std::to_string(seed) + "\"\n" + RandomGraph{seed, lanes}.text(false);
    INFO(text);
    REQUIRE(programs.add(text, exact_options(), file) == "");
    texts[seed] = text;
  }
  programs.compile();
  for (const auto& [seed, text] : texts) {
    INFO(text);
    const Channels in{noise(kFrames, seed), noise(kFrames, seed + 1)};
    auto engine = engine_for(parse_graph_leniently(text, file), exact_options());
    std::mt19937 bits(seed);
    std::vector<JournalEntry> journal;
    std::vector<CompiledPrograms::Move> moves;
    const auto& controls = engine.plan().controls;
    for (int m = 0; !controls.empty() && m < 20; ++m) {
      const auto control = bits() % controls.size();
      // Each ramp ends before the next move, which may have the same target.
      const int frame = static_cast<int>(300 * m + static_cast<int>(bits() % 200));
      const double value =
          static_cast<double>(bits()) / 1500000000.0 - 1.4;  // now and then outside of the range
      journal.push_back({.frame = frame,
                         .kind = JournalEntry::Kind::ControlChange,
                         .index = static_cast<int>(control),
                         .value = value});
      moves.push_back({frame, controls[control].control.name, value});
    }
    engine.set_journal(journal);
    CHECK(first_difference(programs.run("random_" + std::to_string(seed), in, kFrames, moves),
                           run(engine, in, kFrames, {64})) == "");
  }
}

namespace {

/// Largest error of other numbers and recurrences, as a share of the largest value: docs/export.md. A
/// recurrence in another order differs by roundings, which a low corner amplifies; so do floats, 1.2e-7.
struct ErrorBound {
  const char* type;
  double plain, single;
};
constexpr double kOneFrame = 2;  ///< rounded to another frame, a signal may be anything within its range
/// At a singularity of a closed chain, and where a contact begins in another frame.
constexpr double kAnything = std::numeric_limits<double>::infinity();
constexpr ErrorBound kOthers = {"", 0, 1e-4};
constexpr ErrorBound kErrorBounds[] = {
    {"low_pass", 1e-11, 1e-2}, {"band_pass", 1e-11, 1e-2},  {"high_pass", 1e-12, 1e-3},
    {"one_pole", 1e-13, 1e-4}, {"dc_blocker", 1e-13, 1e-4}, {"velocity", 1e-13, 1e-4},
    {"string", 1e-13, 1e-4},   {"waveguide", 1e-13, 1e-4},  {"adsr", 0, 1e-3},
    {"stroke", 0, 1e-3},       {"delay", 0, kOneFrame},     {"event_delay", 0, kOneFrame},
    {"six_axis", 0, 1e-3},     {"five_bar", 0, kAnything},  {"delta", 0, kAnything},
    {"proxy", 0, kAnything}};

ErrorBound bound_of(const std::string& type) {
  const auto found =
      std::ranges::find_if(kErrorBounds, [&](const ErrorBound& bound) { return type == bound.type; });
  return found == std::end(kErrorBounds) ? kOthers : *found;
}

}  // namespace

TEST_CASE("export: plain recurrences and floats are within their stated errors of the engine", "[export]") {
  const TemporaryFolder folder;
  copy_files(folder);
  const auto file = (folder.path() / "test.toml").string();
  auto plain = exact_options();
  plain.recurrence = RecurrenceForm::Plain;
  auto single = plain;
  single.number = find_number_type("float");
  CompiledPrograms plains, singles;
  std::map<std::string, CaseGraph> graphs;
  for (const auto* type : standard_nodes().types) {
    graphs[type->name] = graph_of(*type);
    REQUIRE(plains.add(graphs[type->name].text, plain, file) == "");
    REQUIRE(singles.add(graphs[type->name].text, single, file) == "");
  }
  plains.compile();
  singles.compile("-O1 -Wdouble-promotion");
  for (const auto* type : standard_nodes().types) {
    INFO(type->name);
    const auto& graph = graphs[type->name];
    auto engine = engine_for(parse_graph_leniently(graph.text, file), exact_options());
    const auto expected = run(engine, graph.inputs, kFrames, {64});
    const auto bound = bound_of(type->name);
    CHECK(relative_error(expected, plains.run("node_" + type->name, graph.inputs, kFrames)) <= bound.plain);
    CHECK(relative_error(expected, singles.run("node_" + type->name, graph.inputs, kFrames)) <= bound.single);
  }
}
