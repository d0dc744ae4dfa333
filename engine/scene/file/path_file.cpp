#include "engine/scene/file/path_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/graph/plan/compile.h"
#include "engine/graph/semantics/scope.h"
#include "engine/nodes/table.h"
#include "engine/rig/rig.h"

namespace tactus {
namespace {

constexpr const char* kForm =
    "a measured path must have one input, one fir node 'path' and one output with from = \"path\"";

enum FirSetting { kTaps, kRate };

void report(ErrorList& errors, const Source& at, const std::string& what) {
  errors.add(Errc::BadFile, at, what, kForm);
}

const NodeSpec* path_node(const GraphSpec& graph, ErrorList& errors) {
  const auto is_path = [](const NodeSpec& node) {
    return node.name == "path" && node.type == fir_type().name;
  };
  const auto others = [&](const auto& items, auto&& belongs) {
    for (const auto& item : items)
      if (!belongs(item)) report(errors, item.at, "'" + item.name + "' is not part of a measured path");
  };
  const auto none = [](const auto&) { return false; };
  others(graph.nodes, is_path);
  others(graph.networks, none);
  others(graph.controls, none);
  const auto path = std::ranges::find_if(graph.nodes, is_path);
  if (path != graph.nodes.end()) return &*path;
  report(errors, {graph.file.file, 1, 1}, "there is no fir node called 'path'");
  return nullptr;
}

/// What comes before or behind the taps would be lost.
void check_ends(const GraphSpec& graph, const NodeSpec& node, ErrorList& errors) {
  if (graph.inputs.size() != 1 || graph.outputs.size() != 1)
    return report(
        errors, {graph.file.file, 1, 1},
        fmt::format("there are {} inputs and {} outputs", graph.inputs.size(), graph.outputs.size()));
  const auto expect = [&](const Value* value, const char* key, const std::string& name) {
    if (value != nullptr && (value->text() == nullptr || *value->text() != name))
      report(errors, value->at, fmt::format("'{}' is not \"{}\" alone", key, name));
  };
  expect(find(node.fields, "in"), "in", graph.inputs[0].name);
  expect(find(graph.outputs[0].fields, "from"), "from", "path");
}

std::string lines_of(const std::vector<double>& taps) {
  std::string text;
  for (std::size_t k = 0; k < taps.size(); ++k)
    text += fmt::format("{}{:.8g},", k % 8 == 0 ? "\n  " : " ", taps[k] + 0.0);  // -0 would read back as 0
  return text;
}

}  // namespace

std::string to_text(const PathFile& path) {
  return fmt::format(
      R"(format = 1
name   = {}
about  = {}
source = {}

[inputs]
drive = {{ unit = "full scale", about = "the played signal" }}

[outputs]
sensor = {{ from = "path", unit = "full scale", about = "the sensor signal" }}

[nodes.path]
type = "fir"
in   = "drive"
rate = {}
taps = [{}
]
)",
      in_quotes(path.name), in_quotes(path.about), in_quotes(path.source),
      exact_quantity(path.rate.value, parse_unit("Hz")->dimension), lines_of(path.taps));
}

Checked<PathFile> read_path(LoadedGraph loaded) {
  auto wrong = std::move(loaded.errors);
  if (wrong.empty()) wrong = check(*loaded.spec, standard_nodes(), {});
  if (!wrong.empty()) return tl::unexpected(std::move(wrong));
  const auto& graph = *loaded.spec;
  ErrorList errors{graph.file};
  PathFile path{graph.name, graph.about, graph.source, {}, {}};
  if (const auto* node = path_node(graph, errors)) {
    check_ends(graph, *node, errors);
    const auto setting = [&](FirSetting which) {
      return bind_setting(fir_type().settings[which], node->fields, {}, "fir 'path'", node->at, errors);
    };
    const auto rate = setting(kRate);
    if (!rate.given)
      errors.add(Errc::Missing, node->at, "fir 'path' lacks 'rate'",
                 "give the sample rate of its taps, as in rate = \"48 kHz\"");
    path.rate = Hertz{rate.number};
    path.taps = setting(kTaps).numbers;
  }
  if (errors.any()) return tl::unexpected(errors.take());
  return path;
}

}  // namespace tactus
