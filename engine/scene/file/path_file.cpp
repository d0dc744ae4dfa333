#include "engine/scene/file/path_file.h"

#include <fmt/format.h>

#include "engine/graph/plan/compile.h"
#include "engine/graph/semantics/scope.h"
#include "engine/nodes/table.h"
#include "engine/rig/rig.h"

namespace tactus {
namespace {

constexpr const char* kForm =
    "a measured path must have one input, one fir node 'path' and one output with from = \"path\"";

enum FirSetting { kTaps, kRate };

/// Reads the one node of a graph without errors.
class PathReader {
 public:
  explicit PathReader(const GraphSpec& graph) : graph_(graph), errors_(graph.file) {}

  Checked<PathFile> read() {
    if (const auto* node = the_node()) {
      check_ends(*node);
      read_rate(*node);
      path_.taps = setting(*node, kTaps).numbers;
    }
    if (errors_.any()) return tl::unexpected(errors_.take());
    path_.name = graph_.name;
    path_.about = graph_.about;
    path_.source = graph_.source;
    return path_;
  }

 private:
  void other(const Source& at, const std::string& what) { errors_.add(Errc::BadFile, at, what, kForm); }

  const NodeSpec* the_node() {
    const NodeSpec* path = nullptr;
    for (const auto& node : graph_.nodes)
      if (node.name == "path" && node.type == fir_type().name)
        path = &node;
      else
        other(node.at, "'" + node.name + "' is not part of a measured path");
    const auto others = [this](const auto& items) {
      for (const auto& item : items) other(item.at, "'" + item.name + "' is not part of a measured path");
    };
    others(graph_.networks);
    others(graph_.controls);
    if (path == nullptr) other({graph_.file.file, 1, 1}, "there is no fir node called 'path'");
    return path;
  }

  void check_ends(const NodeSpec& node) {
    if (graph_.inputs.size() != 1 || graph_.outputs.size() != 1)
      return other({graph_.file.file, 1, 1}, fmt::format("there are {} inputs and {} outputs",
                                                         graph_.inputs.size(), graph_.outputs.size()));
    expect(node.fields, "in", graph_.inputs[0].name);
    expect(graph_.outputs[0].fields, "from", "path");
  }

  /// What comes before or behind the taps would be lost.
  void expect(const Value::Table& fields, const char* key, const std::string& name) {
    const auto* value = find(fields, key);
    if (value != nullptr && (value->text() == nullptr || *value->text() != name))
      other(value->at, fmt::format("'{}' is not \"{}\" alone", key, name));
  }

  SettingValue setting(const NodeSpec& node, std::size_t which) {
    return bind_setting(fir_type().settings[which], node.fields, {}, "fir 'path'", node.at, errors_);
  }

  void read_rate(const NodeSpec& node) {
    const auto rate = setting(node, kRate);
    path_.rate = Hertz{rate.number};
    if (!rate.given)
      errors_.add(Errc::Missing, node.at, "fir 'path' lacks 'rate'",
                  "give the sample rate of its taps, as in rate = \"48 kHz\"");
  }

  const GraphSpec& graph_;
  ErrorList errors_;
  PathFile path_;
};

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
  return PathReader{*loaded.spec}.read();
}

}  // namespace tactus
