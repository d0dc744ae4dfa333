#include "engine/graph/plan/compile.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/graph/file/entry_fields.h"
#include "engine/graph/file/mistakes.h"
#include "engine/graph/plan/build_schedule.h"
#include "engine/graph/plan/unfolded_nodes.h"
#include "engine/graph/plan/widen.h"
#include "engine/graph/semantics/infer.h"
#include "engine/graph/semantics/resolve.h"

namespace tactus {
namespace {

/// Which inputs are late, and how late at least, in engine frames.
void delays_of(const VertexGraph& graph, const FlatGraph& flat, const MadeNodes& made,
               std::vector<std::vector<bool>>& late, std::vector<int>& least) {
  late.resize(graph.vertices.size());
  least.assign(graph.vertices.size(), 0);
  for (std::size_t v = 0; v < graph.vertices.size(); ++v) {
    const auto& vertex = graph.vertices[v];
    late[v].assign(vertex.in.size(), false);
    if (vertex.kind != Vertex::Kind::Node) continue;
    const auto& type = *flat.nodes[static_cast<std::size_t>(vertex.index)].type;
    int shortest = std::numeric_limits<int>::max();
    for (std::size_t i = 0; i < vertex.in.size(); ++i) {
      late[v][i] = type.inputs[i].late;
      if (!late[v][i]) continue;
      // A node that could not be made is taken to delay as much as any, so that it seems to close no loop.
      for (int output = 0; made.nodes[v] != nullptr && output < vertex.outputs; ++output)
        shortest = std::min(shortest, made.nodes[v]->delay(static_cast<int>(i), output).least);
    }
    // In engine frames: any stretch of d R of them holds d frames of a part at a rate of 1/R, wherever it
    // begins.
    least[v] = shortest == std::numeric_limits<int>::max()
                   ? kMaxPiece
                   : std::min(shortest, std::numeric_limits<int>::max() / vertex.every) * vertex.every;
  }
}

/// What folded to no number: nothing that reads it could ever sound.
void check_constants(const VertexGraph& graph, Mistakes& mistakes) {
  for (const auto& vertex : graph.vertices)
    if (vertex.alive && vertex.kind == Vertex::Kind::Constant && !std::isfinite(vertex.value))
      mistakes.add(Errc::OutOfRange, vertex.at,
                   "this is always " + std::string{std::isnan(vertex.value) ? "not a number" : "infinite"},
                   "write smaller numbers");
}

void set_controls(FlatGraph& flat, const std::map<std::string, ControlValue>& values, Mistakes& mistakes) {
  for (const auto& setting : values) {
    const auto& name = setting.first;
    const double value = setting.second.si;
    const auto it = std::find_if(flat.controls.begin(), flat.controls.end(),
                                 [&](const auto& c) { return c.name == setting.first; });
    if (it == flat.controls.end()) {
      std::vector<std::string> known;
      for (const auto& control : flat.controls) known.push_back(control.name);
      mistakes.add(Errc::UnknownName, {}, "there is no control '" + name + "'",
                   known.empty() ? "this graph has none" : "this graph has " + listed(known));
    } else if (setting.second.dimension && !(*setting.second.dimension == it->unit.dimension)) {
      const auto in = [](const Dimension& d) {
        return d.plain() ? std::string{"a plain number"} : "in " + to_string(d);
      };
      mistakes.add(Errc::UnitMismatch, {},
                   "control '" + name + "' is " + in(it->unit.dimension) + ", but it is set to what is " +
                       in(*setting.second.dimension),
                   "give it in its own unit");
    } else if (!it->range.contains(value)) {
      mistakes.add(
          Errc::OutOfRange, {}, "control '" + name + "' cannot be set to " + in_unit(value, it->unit),
          "it goes from " + in_unit(it->range.low, it->unit) + " to " + in_unit(it->range.high, it->unit));
    } else {
      it->value = value;
    }
  }
}

/// Broken controls are not in the flat graph, and need no second message.
std::map<std::string, ControlValue> settable(std::map<std::string, ControlValue> values,
                                             const GraphSpec& spec) {
  for (const auto& control : spec.controls)
    if (control.broken) values.erase(control.name);
  if (spec.incomplete) values.clear();
  return values;
}

FlatGraph flatten(const GraphSpec& spec, const NodeTable& table, const CompileOptions& options,
                  Mistakes& mistakes) {
  auto resolved = resolve(spec, table, options.sample_rate, options.taps, options.most_nodes);
  const bool whole = !resolved.too_large;
  mistakes.add(std::move(resolved.mistakes));
  set_controls(resolved.graph, settable(options.controls, spec), mistakes);
  mistakes.add(infer(resolved.graph));
  if (whole && unfolded_nodes(resolved.graph) > options.most_nodes)
    mistakes.add(Errc::OutOfRange, spec.file,
                 "with all its lanes the graph has more than " + std::to_string(options.most_nodes) +
                     " nodes and operators",
                 "take fewer voices, or fewer parts");
  return std::move(resolved.graph);
}

Checked<std::vector<OrderedSection>> ordered(const VertexGraph& graph, const FlatGraph& flat,
                                             const MadeNodes& made, const CompileOptions& options) {
  std::vector<std::vector<bool>> late;
  std::vector<int> least;
  delays_of(graph, flat, made, late, least);
  return order(graph, late, least, options.closed_outside);
}

/// Side by side where that makes no cycle of what was none: a lane may answer another one in the same frame.
std::optional<std::vector<OrderedSection>> put_side_by_side(VertexGraph& graph, const FlatGraph& flat,
                                                            MadeNodes& made, const CompileOptions& options) {
  const bool has_lanes = std::any_of(graph.vertices.begin(), graph.vertices.end(),
                                     [](const Vertex& v) { return v.alive && v.origin; });
  if (!options.side_by_side || !has_lanes) return std::nullopt;
  auto wide = graph;
  if (!widen(wide, flat, made)) return std::nullopt;
  expand_sums(wide, made);
  auto sections = ordered(wide, flat, made, options);
  if (!sections) {
    undo_widen(graph, made);
    return std::nullopt;
  }
  graph = std::move(wide);
  drop_replaced(graph, made);
  return std::move(*sections);
}

Checked<std::unique_ptr<Schedule>> make_schedule(const FlatGraph& flat, const CompileOptions& options) {
  auto graph = lower(flat);
  simplify(graph, flat, options.sample_rate);
  Mistakes mistakes;
  check_constants(graph, mistakes);
  if (mistakes.any()) return tl::unexpected(mistakes.take());
  auto made = make_nodes(graph, flat, options);
  mistakes.add(std::move(made.mistakes));
  auto sections = ordered(graph, flat, made, options);
  if (!sections) mistakes.add(sections.error());
  if (mistakes.any()) return tl::unexpected(mistakes.take());
  if (auto wide = put_side_by_side(graph, flat, made, options))
    sections = std::move(*wide);
  else if (expand_sums(graph, made))
    sections = ordered(graph, flat, made, options);
  return build_schedule(graph, flat, *sections, std::move(made), options);
}

}  // namespace

std::vector<Error> check(const GraphSpec& spec, const NodeTable& table, const CompileOptions& options) {
  Mistakes mistakes{spec.file};
  flatten(spec, table, options, mistakes);
  return mistakes.take();
}

Checked<std::unique_ptr<Schedule>> compile(const GraphSpec& spec, const NodeTable& table,
                                           const CompileOptions& options) {
  Mistakes mistakes{spec.file};
  const auto flat = flatten(spec, table, options, mistakes);
  if (mistakes.any()) return tl::unexpected(mistakes.take());
  auto schedule = make_schedule(flat, options);
  if (schedule) (*schedule)->name = spec.name;
  return schedule;
}

Checked<std::unique_ptr<Schedule>> compile(const LoadedGraph& graph, const NodeTable& table,
                                           const CompileOptions& options) {
  if (graph.spec == nullptr) return tl::unexpected(graph.mistakes);
  if (graph.mistakes.empty()) return compile(*graph.spec, table, options);
  Mistakes mistakes{graph.spec->file};
  mistakes.add(graph.mistakes);
  mistakes.add(check(*graph.spec, table, options));
  return tl::unexpected(mistakes.take());
}

}  // namespace tactus
