#include "engine/graph/compile.h"

#include <algorithm>
#include <limits>

#include "engine/graph/build_schedule.h"
#include "engine/graph/infer.h"
#include "engine/graph/mistakes.h"
#include "engine/graph/resolve.h"

namespace tactus {
namespace {

/// Which inputs are late, and how late at least.
void delays_of(const VertexGraph& graph, const FlatGraph& flat, const MadeNodes& made,
               std::vector<std::vector<bool>>& late, std::vector<int>& least) {
  late.resize(graph.vertices.size());
  least.assign(graph.vertices.size(), 0);
  for (std::size_t v = 0; v < graph.vertices.size(); ++v) {
    const auto& vertex = graph.vertices[v];
    late[v].assign(vertex.in.size(), false);
    if (vertex.kind != Vertex::Kind::Node || made.nodes[v] == nullptr) continue;
    const auto& type = *flat.nodes[static_cast<std::size_t>(vertex.index)].type;
    int shortest = std::numeric_limits<int>::max();
    for (std::size_t i = 0; i < vertex.in.size(); ++i) {
      late[v][i] = type.inputs[i].late;
      if (!late[v][i]) continue;
      for (int output = 0; output < vertex.outputs; ++output)
        shortest = std::min(shortest, made.nodes[v]->delay(static_cast<int>(i), output).least);
    }
    least[v] = shortest == std::numeric_limits<int>::max() ? 0 : shortest;
  }
}

std::vector<Error> set_controls(FlatGraph& flat, const std::map<std::string, double>& values) {
  std::vector<Error> errors;
  for (const auto& setting : values) {
    const auto& [name, value] = setting;
    const auto it = std::find_if(flat.controls.begin(), flat.controls.end(),
                                 [&](const auto& c) { return c.name == setting.first; });
    if (it == flat.controls.end()) {
      std::string known;
      for (const auto& control : flat.controls) known += (known.empty() ? "" : ", ") + control.name;
      errors.push_back({Errc::UnknownName, "", "there is no control '" + name + "'",
                        known.empty() ? "this graph has no controls" : "the controls are " + known});
    } else if (!it->range.contains(value)) {
      errors.push_back({Errc::OutOfRange, "", "control '" + name + "' cannot be set outside its range",
                        "see its 'range' in the file"});
    } else {
      it->value = value;
    }
  }
  return errors;
}

void append(std::vector<Error>& errors, std::vector<Error> more) {
  errors.insert(errors.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

}  // namespace

Checked<std::unique_ptr<Schedule>> compile(const GraphSpec& spec, const NodeTable& table,
                                           const CompileOptions& options) {
  auto [flat, mistakes] = resolve(spec, table, options.sample_rate, options.taps);
  append(mistakes, set_controls(flat, options.controls));
  append(mistakes, infer(flat));
  if (!mistakes.empty()) {
    sort_by_place(mistakes);
    return tl::unexpected(std::move(mistakes));
  }
  auto graph = lower(flat);
  simplify(graph, flat, options.sample_rate);
  auto made = make_nodes(graph, flat, options);
  if (!made) return tl::unexpected(std::move(made.error()));
  std::vector<std::vector<bool>> late;
  std::vector<int> least;
  delays_of(graph, flat, *made, late, least);
  const auto sections = order(graph, late, least, options.closed_outside);
  if (!sections) return tl::unexpected(sections.error());
  auto schedule = build_schedule(graph, flat, *sections, std::move(*made), options);
  schedule->name = spec.name;
  return schedule;
}

}  // namespace tactus
