#include "engine/graph/plan/build_schedule.h"

#include <algorithm>
#include <map>

#include "engine/graph/plan/crossing.h"
#include "engine/graph/plan/find_what_rests.h"
#include "engine/graph/semantics/operators.h"

namespace tactus {
namespace {

class Builder {
 public:
  Builder(const VertexGraph& graph, const FlatGraph& flat, MadeNodes made, const CompileOptions& options)
      : graph_(graph),
        flat_(flat),
        made_(std::move(made)),
        options_(options),
        schedule_(std::make_unique<Schedule>()) {}

  std::unique_ptr<Schedule> run(const std::vector<OrderedSection>& sections) {
    schedule_->sample_rate = options_.sample_rate;
    schedule_->left_out = graph_.left_out;
    lay_out_signals();
    take_nodes();
    for (const auto& section : sections) add_section(section);
    add_channels();
    find_what_rests(*schedule_);
    return std::move(schedule_);
  }

 private:
  const Vertex& at(int v) const { return graph_.vertices[static_cast<std::size_t>(v)]; }

  bool has_buffer(const Vertex& vertex) const {
    return vertex.alive && vertex.kind != Vertex::Kind::Constant && vertex.kind != Vertex::Kind::Output;
  }

  void lay_out_signals() {
    std::size_t doubles = 0;
    first_buffer_.assign(graph_.vertices.size(), 0);
    for (std::size_t v = 0; v < graph_.vertices.size(); ++v) {
      first_buffer_[v] = doubles;
      if (has_buffer(graph_.vertices[v]))
        doubles +=
            static_cast<std::size_t>(graph_.vertices[v].outputs * graph_.vertices[v].width) * kMaxPiece;
    }
    schedule_->arena.resize(doubles);
    schedule_->input_names = graph_.inputs;
    schedule_->input_buffers.assign(graph_.inputs.size(), nullptr);
    for (std::size_t c = 0; c < flat_.controls.size(); ++c) {
      schedule_->controls.push_back({flat_.controls[c], nullptr, {}, made_.frozen_controls[c]});
    }
    for (std::size_t v = 0; v < graph_.vertices.size(); ++v) {
      const auto& vertex = graph_.vertices[v];
      if (!vertex.alive) continue;
      if (vertex.kind == Vertex::Kind::Input)
        schedule_->input_buffers[static_cast<std::size_t>(vertex.index)] = buffer(v, 0);
      if (vertex.kind == Vertex::Kind::Control)
        schedule_->controls[static_cast<std::size_t>(vertex.index)].buffer = buffer(v, 0);
      if (vertex.kind == Vertex::Kind::SystemDelay) schedule_->system_delay = buffer(v, 0);
    }
    schedule_->system_delay_at_start = options_.system_delay;
  }

  double* buffer(std::size_t v, int port) const {
    return schedule_->arena.data() + first_buffer_[v] +
           static_cast<std::size_t>(port * graph_.vertices[v].width) * kMaxPiece;
  }

  Signal signal(Wire wire) {
    const auto v = static_cast<std::size_t>(wire.vertex);
    const auto& vertex = graph_.vertices[v];
    if (vertex.width > 1) return wide_signal(wire);
    if (vertex.kind == Vertex::Kind::Constant) {
      auto& cell = constant_cells_[v];
      if (cell == nullptr) {
        schedule_->constants.push_back(std::make_unique<double>(vertex.value));
        cell = schedule_->constants.back().get();
      }
      return {cell, 0};
    }
    // Controls rest until they are moved; the engine sets the stride while they ramp.
    const bool rests = vertex.kind == Vertex::Kind::Control || vertex.kind == Vertex::Kind::SystemDelay;
    return {buffer(v, wire.port), rests ? 0 : 1};
  }

  /// A lane of what is wide is a signal with a longer stride.
  Signal wide_signal(Wire wire) {
    const auto& vertex = at(wire.vertex);
    if (vertex.kind != Vertex::Kind::Constant)
      return {buffer(static_cast<std::size_t>(wire.vertex), wire.port) + std::max(0, wire.lane), kWide};
    auto& cells = *schedule_->wide_constants.emplace_back(std::make_unique<std::array<double, kWide>>());
    std::copy_n(vertex.values.begin(), kWide, cells.begin());
    return {cells.data(), 0};
  }

  int add_inputs(const std::vector<Wire>& wires) {
    const int first = static_cast<int>(schedule_->inputs.size());
    for (const auto& wire : wires) schedule_->inputs.push_back(signal(wire));
    return first;
  }

  void take_nodes() {
    read_.assign(graph_.vertices.size(), {});
    for (const auto& vertex : graph_.vertices) {
      if (!vertex.alive) continue;
      for (const auto& wire : vertex.in) read_[static_cast<std::size_t>(wire.vertex)].push_back(wire.port);
    }
    node_index_.assign(graph_.vertices.size(), -1);
    for (std::size_t v = 0; v < graph_.vertices.size(); ++v) {
      if (made_.nodes[v] == nullptr) continue;
      node_index_[v] = static_cast<int>(schedule_->nodes.size());
      schedule_->nodes.push_back(std::move(made_.nodes[v]));
      schedule_->fingerprints.push_back(made_.fingerprints[v]);
      const auto& vertex = graph_.vertices[v];
      schedule_->types.push_back(vertex.kind == Vertex::Kind::Node
                                     ? flat_.nodes[static_cast<std::size_t>(vertex.index)].type
                                     : nullptr);
      schedule_->whats.push_back(what_is(vertex));
    }
  }

  std::string what_is(const Vertex& vertex) const {
    switch (vertex.kind) {
      case Vertex::Kind::Node:
        return flat_.nodes[static_cast<std::size_t>(vertex.index)].type->name;
      case Vertex::Kind::PhaseDelay:
        return "phase delay";
      case Vertex::Kind::Sum:
        return "sum of lanes";
      case Vertex::Kind::Pack:
        return "pack";
      case Vertex::Kind::Crossing:
        return vertex.every > vertex.crossing.from ? "to 1/" + std::to_string(vertex.every)
                                                   : "from 1/" + std::to_string(vertex.crossing.from);
      default:
        return "1 operation";
    }
  }

  int pace(int every) {
    auto& paces = schedule_->paces;
    const auto found = std::find(paces.begin(), paces.end(), every);
    if (found != paces.end()) return static_cast<int>(found - paces.begin());
    paces.push_back(every);
    return static_cast<int>(paces.size()) - 1;
  }

  void set_paces(Step& step, const Vertex& vertex) {
    const bool crosses = vertex.kind == Vertex::Kind::Crossing;
    step.pace = pace(crosses ? Crossing::runs_every(vertex.crossing, vertex.every) : vertex.every);
    step.pace_in = pace(crosses ? vertex.crossing.from : vertex.every);
    step.pace_out = pace(vertex.every);
  }

  int path(const std::string& text) {
    const auto [it, added] = path_index_.emplace(text, static_cast<int>(schedule_->paths.size()));
    if (added) schedule_->paths.push_back(text);
    return it->second;
  }

  void add_section(const OrderedSection& ordered) {
    Section section;
    section.first_step = static_cast<int>(schedule_->steps.size());
    section.sub_block = ordered.sub_block;
    section.loop = ordered.loop;
    for (const auto& item : ordered.vertices) add_step(item, section.first_step);
    section.end_step = static_cast<int>(schedule_->steps.size());
    if (section.end_step == section.first_step) return;
    if (section.loop) report_loop(ordered);
    // Straight parts that follow one another (what only names inputs is no step) run as one.
    auto& sections = schedule_->sections;
    if (!section.loop && !sections.empty() && !sections.back().loop)
      sections.back().end_step = section.end_step;
    else
      sections.push_back(section);
  }

  void add_step(const OrderedVertex& item, int section_start) {
    using Half = OrderedVertex::Half;
    Step step;
    if (item.half == Half::Outside) {
      step.kind = Step::Kind::Outside;
      step.path = path("outside");
      schedule_->steps.push_back(step);
      return;
    }
    const auto& vertex = at(item.vertex);
    const int node = node_index_[static_cast<std::size_t>(item.vertex)];
    if (node < 0 && vertex.kind == Vertex::Kind::Operation)
      return add_operation(item.vertex, vertex, section_start);
    if (node < 0) return;
    step.kind = item.half == Half::Emit     ? Step::Kind::Emit
                : item.half == Half::Absorb ? Step::Kind::Absorb
                                            : Step::Kind::Process;
    step.node = node;
    step.width = vertex.width;
    set_paces(step, vertex);
    step.can_fail = vertex.kind != Vertex::Kind::Pack && vertex.kind != Vertex::Kind::Crossing &&
                    (vertex.kind != Vertex::Kind::Operation || can_overflow(vertex.op));
    step.first_in = add_inputs(vertex.in);
    step.inputs = static_cast<int>(vertex.in.size());
    step.first_out = static_cast<int>(schedule_->outputs.size());
    step.outputs = vertex.outputs;
    const auto* type = schedule_->types[static_cast<std::size_t>(step.node)].get();
    const bool skips = type != nullptr && type->skips_unread;
    const auto& ports = read_[static_cast<std::size_t>(item.vertex)];
    for (int port = 0; port < vertex.outputs; ++port) {
      const bool read = !skips || std::find(ports.begin(), ports.end(), port) != ports.end();
      schedule_->outputs.push_back(read ? buffer(static_cast<std::size_t>(item.vertex), port) : nullptr);
    }
    step.path = path(vertex.path);
    schedule_->steps.push_back(step);
  }

  void add_operation(int v, const Vertex& vertex, int section_start) {
    auto& steps = schedule_->steps;
    if (static_cast<int>(steps.size()) == section_start || steps.back().kind != Step::Kind::Operations ||
        steps.back().pace != pace(vertex.every)) {
      Step step;
      set_paces(step, vertex);
      step.kind = Step::Kind::Operations;
      step.first_operation = static_cast<int>(schedule_->operations.size());
      step.first_out = static_cast<int>(schedule_->outputs.size());
      step.path = path(vertex.path);
      steps.push_back(step);
    }
    MicroOperation operation;
    operation.op = vertex.op;
    operation.first_in = add_inputs(vertex.in);
    if (vertex.in.size() == 1) add_inputs(vertex.in);  // every operation has two operands to point at
    operation.out = buffer(static_cast<std::size_t>(v), 0);
    operation.path = path(vertex.path);
    schedule_->operations.push_back(operation);
    schedule_->outputs.push_back(operation.out);
    ++steps.back().operations;
    ++steps.back().outputs;
  }

  void report_loop(const OrderedSection& ordered) {
    LoopReport report;
    report.sub_block = ordered.sub_block;
    report.delay_frames = ordered.delay_frames;
    for (const auto& item : ordered.vertices)
      if (item.half != OrderedVertex::Half::Absorb && item.half != OrderedVertex::Half::Outside &&
          (report.paths.empty() || report.paths.back() != at(item.vertex).path))
        report.paths.push_back(at(item.vertex).path);
    schedule_->loops.push_back(std::move(report));
  }

  void add_channels() {
    schedule_->channels.resize(graph_.outputs.size());
    for (const auto& vertex : graph_.vertices) {
      if (vertex.kind != Vertex::Kind::Output) continue;
      auto& channel = schedule_->channels[static_cast<std::size_t>(vertex.index)];
      const auto& output = graph_.outputs[static_cast<std::size_t>(vertex.index)];
      channel = {output.name, output.use, output.dimension, signal(vertex.in.front())};
    }
  }

  const VertexGraph& graph_;
  const FlatGraph& flat_;
  MadeNodes made_;
  const CompileOptions& options_;
  std::unique_ptr<Schedule> schedule_;
  std::vector<std::size_t> first_buffer_;
  std::vector<std::vector<int>> read_;  ///< [vertex]: ports that somebody reads
  std::vector<int> node_index_;
  std::map<std::size_t, double*> constant_cells_;
  std::map<std::string, int> path_index_;
};

}  // namespace

std::unique_ptr<Schedule> build_schedule(const VertexGraph& graph, const FlatGraph& flat,
                                         const std::vector<OrderedSection>& sections, MadeNodes made,
                                         const CompileOptions& options) {
  return Builder{graph, flat, std::move(made), options}.run(sections);
}

}  // namespace tactus
