#include "engine/graph/plan/compile.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/core/named.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/file/read_graph.h"
#include "engine/graph/semantics/facts.h"

namespace tactus {
namespace {

/// Of one lane of an expression; a list has one entry for each lane.
std::size_t size_of(const Expression& expression) {
  if (expression.op == Expression::Op::Lanes || expression.op == Expression::Op::Spread ||
      expression.op == Expression::Op::Pick)
    return 1;
  std::size_t size = 1;
  for (const auto& argument : expression.arguments) size += size_of(argument);
  return size;
}

/// Nodes and operators, those of each lane counted separately.
std::size_t unfolded_nodes(const FlatGraph& graph) {
  std::size_t count = 0;
  for (const auto& signal : graph.signals)
    count += index(signal.lanes) *
             (signal.kind == FlatSignal::Kind::Expression ? 1 + size_of(signal.expression) : 1);
  for (const auto& node : graph.nodes) {
    std::size_t inputs = 1 + node.inputs.size() * (1 + node.compensate.size());
    for (const auto& input : node.inputs)
      if (input) inputs += size_of(*input);
    count += index(node.lanes) * inputs;
  }
  for (const auto& output : graph.outputs) count += index(output.lanes) * (1 + size_of(output.expression));
  return count;
}

/// A constant that is not finite: nothing that reads it can ever sound.
void check_constants(const VertexGraph& graph, ErrorList& errors) {
  for (const auto& vertex : graph.vertices)
    if (vertex.alive && vertex.kind == Vertex::Kind::Constant && !std::isfinite(vertex.value))
      errors.add(Errc::OutOfRange, vertex.at,
                 "this is always " + std::string{std::isnan(vertex.value) ? "not a number" : "infinite"},
                 "write smaller numbers");
}

void set_controls(FlatGraph& flat, const GraphSpec& spec, const std::map<std::string, ControlValue>& values,
                  ErrorList& errors) {
  for (const auto& [name, setting] : values) {
    auto* const it = find_named(flat.controls, name);
    const double value = it != nullptr && setting.dimension
                             ? converted(setting.si, *setting.dimension, it->unit.dimension)
                             : setting.si;
    const auto* written = find_named(spec.controls, name);
    if (spec.incomplete || (written && written->broken))
      continue;  // it is not in the flat graph, and needs no second message
    if (it == nullptr) {
      const auto known = names_of(flat.controls);
      errors.add(Errc::UnknownName, {}, "there is no control '" + name + "'",
                 known.empty() ? "this graph has no controls" : "this graph has " + listed(known));
    } else if (setting.dimension && !(*setting.dimension == it->unit.dimension)) {
      errors.add(Errc::UnitMismatch, {},
                 "control '" + name + "' is " + unit_phrase(it->unit.dimension) + ", but its new value is " +
                     unit_phrase(*setting.dimension),
                 "give the value in the unit of the control");
    } else if (!it->range.contains(value)) {
      errors.add(Errc::OutOfRange, {}, "control '" + name + "' cannot be set to " + in_unit(value, it->unit),
                 limits_text(it->range.low, it->range.high, it->unit));
    } else if (written != nullptr && takes_whole_numbers(*written) && std::floor(value) != value) {
      errors.add(Errc::OutOfRange, {}, "control '" + name + "' cannot be set to " + in_unit(value, it->unit),
                 kGiveWholeNumber);
    } else {
      it->value = value;
    }
  }
}

FlatGraph flatten(const GraphSpec& spec, const NodeTable& table, const CompileOptions& options,
                  ErrorList& errors) {
  auto resolved = resolve(spec, table, options.sample_rate, errors, options.taps, options.most_nodes);
  auto& flat = resolved.graph;
  set_controls(flat, spec, options.controls, errors);
  infer(flat, resolved.part_ranges, errors);
  if (!flat.too_large && unfolded_nodes(flat) > options.most_nodes)
    errors.add(Errc::OutOfRange, spec.file,
               "with all lanes the graph has more than " + std::to_string(options.most_nodes) +
                   " nodes and operators",
               "use fewer voices or fewer parts");
  return std::move(flat);
}

/// nullptr after an error.
std::unique_ptr<Plan> make_plan(const FlatGraph& flat, const CompileOptions& options, ErrorList& errors,
                                bool merges = true) {
  auto graph = lower(flat);
  simplify(graph, flat, options.sample_rate);
  const auto written = graph.vertices.size();
  if (merges) merge_equal(graph, flat);
  merges = graph.vertices.size() < written;
  check_constants(graph, errors);
  if (errors.any()) return nullptr;
  const auto frozen_controls = make_nodes(graph, flat, options, errors);
  const auto expand_and_order = [&] {
    if (!errors.any()) expand_sums(graph);
    return order(graph, options.closed_outside);
  };
  auto scalar = graph;
  const bool vectorised = options.vectorise && !errors.any() && vectorise(graph, flat);
  auto sections = expand_and_order();
  if (!sections &&
      vectorised) {  // a lane may answer another one in the same frame: a cycle if they run together
    graph = std::move(scalar);
    sections = expand_and_order();
  }
  // An error names what is written, not another node that equals it.
  if (!sections && merges && !errors.any()) return make_plan(flat, options, errors, false);
  if (!sections) errors.add(sections.error());
  if (errors.any()) return nullptr;
  return build_plan(std::move(graph), flat, *sections, frozen_controls, options);
}

}  // namespace

std::vector<Error> check(const GraphSpec& spec, const NodeTable& table, const CompileOptions& options) {
  ErrorList errors{spec.file};
  flatten(spec, table, options, errors);
  return errors.take();
}

Checked<std::unique_ptr<Plan>> compile(const GraphSpec& spec, const NodeTable& table,
                                       const CompileOptions& options) {
  ErrorList errors{spec.file};
  const auto flat = flatten(spec, table, options, errors);
  if (errors.any()) return tl::unexpected(errors.take());
  auto plan = make_plan(flat, options, errors);
  if (plan == nullptr) return tl::unexpected(errors.take());
  plan->name = spec.name;
  plan->warnings = errors.take_warnings();
  return plan;
}

Checked<std::unique_ptr<Plan>> compile(const LoadedGraph& graph, const NodeTable& table,
                                       const CompileOptions& options) {
  if (graph.spec == nullptr) return tl::unexpected(graph.errors);
  if (graph.errors.empty()) return compile(*graph.spec, table, options);
  ErrorList errors{graph.spec->file};
  errors.add(graph.errors);
  errors.add(check(*graph.spec, table, options));
  return tl::unexpected(errors.take());
}

}  // namespace tactus
