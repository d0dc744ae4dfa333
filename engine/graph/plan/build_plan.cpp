#include <algorithm>
#include <map>

#include "engine/graph/plan/compile.h"
#include "engine/graph/plan/inserted_nodes.h"
#include "engine/graph/semantics/operators.h"

namespace tactus {
namespace {

class Builder {
  using Kind = Vertex::Kind;

 public:
  Builder(VertexGraph graph, const FlatGraph& flat, const CompileOptions& options)
      : flat_(flat), options_(options), plan_(std::make_unique<Plan>()) {
    static_cast<VertexGraph&>(*plan_) = std::move(graph);
  }

  std::unique_ptr<Plan> run(const std::vector<OrderedSection>& sections,
                            const std::vector<bool>& frozen_controls) {
    plan_->sample_rate = options_.sample_rate;
    plan_->system_delay_at_start = options_.system_delay;
    find_read_ports();
    find_input_lanes();
    lay_out();
    take_nodes();
    name_sources(frozen_controls);
    for (const auto& section : sections) add_section(section);
    add_channels();
    find_feedback_paths(*plan_);
    find_readers_at_rest();
    point_at_operands();
    for (auto& vertex : plan_->vertices) vertex.origin = {};
    return std::move(plan_);
  }

 private:
  Vertex& at(int v) { return plan_->vertices[index(v)]; }

  void find_read_ports() {
    read_.assign(plan_->vertices.size(), {});
    for (const auto& vertex : plan_->vertices)
      for (const auto& wire : vertex.in) read_[index(wire.vertex)].push_back(wire.port);
  }

  void find_input_lanes() {
    input_lanes_.assign(plan_->vertices.size(), {});
    const auto only_here = [this](const Wire& wire) {
      return at(wire.vertex).kind == Kind::Input && read_[index(wire.vertex)].size() == 1;
    };
    for (int v = 0; v < static_cast<int>(plan_->vertices.size()); ++v) {
      const auto& vertex = at(v);
      if (vertex.kind != Kind::Pack || vertex.divisor != 1 || !std::ranges::all_of(vertex.in, only_here))
        continue;
      for (int lane = 0; lane < kVectorWidth; ++lane)
        input_lanes_[index(vertex.in[index(lane)].vertex)] = {v, 0, lane};
    }
  }
  /// An input that is a lane of a Pack, and nothing else.
  bool is_input_lane(std::size_t v) const { return input_lanes_[v].vertex >= 0; }
  /// A Pack of such inputs.
  bool packs_inputs(const Vertex& vertex) const {
    return vertex.kind == Kind::Pack && is_input_lane(index(vertex.in[0].vertex));
  }

  /// Signals, then constants; of these the vectorised ones first, so that they lie on cache lines.
  void lay_out() {
    enum { kSignal, kVector, kScalar, kNowhere };
    const auto part_of = [&](std::size_t v) {
      const auto& vertex = plan_->vertices[v];
      if (vertex.kind == Kind::Output || is_input_lane(v) ||
          (vertex.kind == Kind::Constant && read_[v].empty()))
        return kNowhere;
      return vertex.kind != Kind::Constant ? kSignal : vertex.width > 1 ? kVector : kScalar;
    };
    place_.assign(plan_->vertices.size(), 0);
    std::size_t doubles = 0;
    for (const auto part : {kSignal, kVector, kScalar}) {
      for (std::size_t v = 0; v < place_.size(); ++v) {
        if (part_of(v) != part) continue;
        const auto& vertex = plan_->vertices[v];
        place_[v] = doubles;
        doubles += index(vertex.width) * (part == kSignal ? index(vertex.outputs) * kMaxSubBlock : 1);
      }
      if (part == kSignal) plan_->signal_doubles = doubles;
    }
    plan_->arena.resize(doubles);
    for (std::size_t v = 0; v < place_.size(); ++v) {
      const auto& vertex = plan_->vertices[v];
      if (const auto part = part_of(v); part == kVector || part == kScalar)
        std::copy_n(part == kScalar ? &vertex.value : vertex.values.data(), vertex.width,
                    plan_->arena.data() + place_[v]);
    }
  }

  void name_sources(const std::vector<bool>& frozen_controls) {
    plan_->input_buffers.assign(plan_->input_names.size(), {});
    for (std::size_t c = 0; c < flat_.controls.size(); ++c)
      plan_->controls.push_back({flat_.controls[c], nullptr, {}, frozen_controls[c]});
    for (int v = 0; v < static_cast<int>(plan_->vertices.size()); ++v) {
      const auto& vertex = at(v);
      if (vertex.kind == Kind::Input) plan_->input_buffers[index(vertex.index)] = input_buffer(v);
      if (vertex.kind == Kind::Control) plan_->controls[index(vertex.index)].buffer = buffer(v, 0);
      if (vertex.kind == Kind::SystemDelay) plan_->system_delay = buffer(v, 0);
    }
  }

  double* buffer(int v, int port) {
    return plan_->arena.data() + place_[index(v)] + port * at(v).width * kMaxSubBlock;
  }

  InputBuffer input_buffer(int v) {
    if (!is_input_lane(index(v))) return {buffer(v, 0)};
    const auto& lane = input_lanes_[index(v)];
    return {buffer(lane.vertex, 0) + lane.lane, kVectorWidth};
  }

  /// A lane of a vectorised vertex is a signal with a longer stride. Controls rest until they are moved;
  /// their stride is set while they ramp.
  Signal signal(const Wire& wire) {
    const auto& vertex = at(wire.vertex);
    if (vertex.kind == Kind::Input) {
      const auto at = input_buffer(wire.vertex);
      return {at.data, at.stride};
    }
    double* const data = buffer(wire.vertex, wire.port);
    if (vertex.kind == Kind::Constant) return {data, 0};
    if (vertex.width > 1) return {data + std::max(0, wire.lane), kVectorWidth};
    const bool rests = vertex.kind == Kind::Control || vertex.kind == Kind::SystemDelay;
    return {data, rests ? 0 : 1};
  }

  void add_input(const Wire& wire) {
    plan_->inputs.push_back(signal(wire));
    sources_.push_back(wire.vertex);
  }

  int add_inputs(Vertex& vertex) {
    const int first = static_cast<int>(plan_->inputs.size());
    for (const auto& wire : vertex.in) add_input(wire);
    if (vertex.first_in < 0) vertex.first_in = first;
    return first;
  }

  void take_nodes() {
    for (auto& vertex : plan_->vertices) {
      if (vertex.node == nullptr) continue;
      vertex.runs = static_cast<int>(plan_->nodes.size());
      plan_->nodes.push_back(std::move(vertex.node));
    }
  }

  /// Several operations of one expression have one path, and so have vectorised ones.
  void number(Vertex& vertex) {
    if (vertex.first_in < 0) vertex.nth = paths_[{vertex.runs < 0, vertex.path}]++;
  }

  int divider(int divisor) {
    auto& divisors = plan_->divisors;
    const auto found = std::ranges::find(divisors, divisor);
    const auto place = found - divisors.begin();
    if (found == divisors.end()) divisors.push_back(divisor);
    return static_cast<int>(place);
  }

  void set_dividers(Step& step, const Vertex& vertex) {
    const bool crosses = vertex.kind == Kind::RateConverter;
    step.divider =
        divider(crosses ? RateConverter::runs_every(vertex.conversion, vertex.divisor) : vertex.divisor);
    step.divider_in = divider(crosses ? vertex.conversion.from : vertex.divisor);
    step.divider_out = divider(vertex.divisor);
    step.divided = step.with_care = (step.divider | step.divider_in | step.divider_out) != 0;
  }

  void add_section(const OrderedSection& ordered) {
    Section section{static_cast<int>(plan_->steps.size()), 0, ordered.sub_block, ordered.loop};
    for (const auto& item : ordered.vertices) add_step(item, section.first_step);
    section.end_step = static_cast<int>(plan_->steps.size());
    if (section.end_step == section.first_step) return;
    if (section.loop) report_loop(ordered);
    // Straight parts that follow one another (what only names inputs is no step) run as one.
    auto& sections = plan_->sections;
    if (!section.loop && !sections.empty() && !sections.back().loop)
      sections.back().end_step = section.end_step;
    else
      sections.push_back(section);
  }

  void add_step(const OrderedVertex& item, int section_start) {
    Step step;
    step.kind = item.step;
    step.with_care = item.step == StepKind::Outside;
    if (item.step == StepKind::Outside) return plan_->steps.push_back(step);
    auto& vertex = at(item.vertex);
    if (vertex.runs < 0 && vertex.kind == Kind::Operation)
      return add_operation(item.vertex, vertex, section_start);
    if (vertex.runs < 0) return;
    number(vertex);
    step.vertex = item.vertex;
    step.node = vertex.runs;
    step.width = vertex.width;
    set_dividers(step, vertex);
    const bool can_fail = vertex.kind != Kind::Pack && vertex.kind != Kind::RateConverter &&
                          (vertex.kind != Kind::Operation || operator_of(vertex.op).can_fail);
    step.first_in = add_inputs(vertex);
    if (packs_inputs(vertex)) return add_input_lanes(vertex, item.vertex);
    step.inputs = static_cast<int>(vertex.in.size());
    step.first_out = static_cast<int>(plan_->outputs.size());
    step.outputs = vertex.outputs;
    const bool skips = vertex.type != nullptr && vertex.type->skips_unused_outputs;
    const auto& ports = read_[index(item.vertex)];
    for (int port = 0; port < vertex.outputs; ++port) {
      const bool read = !skips || std::find(ports.begin(), ports.end(), port) != ports.end();
      plan_->outputs.push_back(read ? buffer(item.vertex, port) : nullptr);
      if (read && can_fail) step.can_fail = port + 1;
    }
    plan_->steps.push_back(step);
  }

  void add_input_lanes(const Vertex& pack, int v) {
    InputLanes lanes{.to = buffer(v, 0)};
    std::ranges::transform(pack.in, lanes.channels.begin(),
                           [this](const Wire& wire) { return at(wire.vertex).index; });
    plan_->input_lanes.push_back(lanes);
  }

  void add_operation(int v, Vertex& vertex, int section_start) {
    auto& steps = plan_->steps;
    if (static_cast<int>(steps.size()) == section_start || steps.back().kind != Step::Kind::Operations ||
        steps.back().divider != divider(vertex.divisor)) {
      Step step;
      set_dividers(step, vertex);
      step.kind = Step::Kind::Operations;
      step.vertex = v;
      step.first_operation = static_cast<int>(plan_->operations.size());
      step.first_out = static_cast<int>(plan_->outputs.size());
      steps.push_back(step);
    }
    number(vertex);
    MicroOperation operation;
    operation.op = vertex.op;
    operation.vertex = v;
    operation.first_in = add_inputs(vertex);
    for (auto has = vertex.in.size(); has < kMostOperands; ++has) add_input(vertex.in[0]);
    operation.operands = operator_of(vertex.op).operands;
    operation.value = operator_of(vertex.op).value;
    operation.can_fail = operator_of(vertex.op).can_fail;
    operation.out = buffer(v, 0);
    if (std::all_of(vertex.in.begin(), vertex.in.end(),
                    [this](const Wire& wire) { return can_rest(wire); })) {
      operation.can_rest = can_rest_[v] = static_cast<int>(plan_->can_rest.size());
      plan_->can_rest.emplace_back();
    }
    plan_->operations.push_back(operation);
    plan_->outputs.push_back(operation.out);
    ++steps.back().operations;
    ++steps.back().outputs;
  }

  bool can_rest(const Wire& wire) {
    const auto kind = at(wire.vertex).kind;
    return kind == Kind::Constant || kind == Kind::Control || kind == Kind::SystemDelay ||
           can_rest_.contains(wire.vertex);
  }

  void report_loop(const OrderedSection& ordered) {
    LoopReport report{{}, ordered.sub_block, ordered.delay_frames};
    for (const auto& item : ordered.vertices)
      if (item.step != StepKind::Absorb && item.step != StepKind::Outside &&
          (report.paths.empty() || report.paths.back() != at(item.vertex).path))
        report.paths.push_back(at(item.vertex).path);
    plan_->loops.push_back(std::move(report));
  }

  void add_channels() {
    for (const auto& vertex : plan_->vertices) {
      if (vertex.kind != Kind::Output) continue;
      auto& channel = plan_->channels[index(vertex.index)];
      channel.from = vertex.in.front();
      channel.signal = signal(channel.from);
    }
  }

  /// The slots and channels that read a control, or an operation that can rest.
  Readers* readers_of(int source) {
    const auto& vertex = at(source);
    if (vertex.kind == Kind::Control) return &plan_->controls[index(vertex.index)].readers;
    const auto found = can_rest_.find(source);
    return found == can_rest_.end() ? nullptr : &plan_->can_rest[index(found->second)];
  }

  void find_readers_at_rest() {
    for (std::size_t slot = 0; slot < sources_.size(); ++slot)
      if (auto* readers = readers_of(sources_[slot])) readers->slots.push_back(static_cast<int>(slot));
    for (std::size_t c = 0; c < plan_->channels.size(); ++c)
      if (auto* readers = readers_of(plan_->channels[c].from.vertex))
        readers->channels.push_back(static_cast<int>(c));
  }

  /// When all operands and outputs have their place.
  void point_at_operands() {
    for (auto& step : plan_->steps) {
      step.in = plan_->inputs.data() + step.first_in;
      step.out = plan_->outputs.data() + step.first_out;
    }
    for (auto& operation : plan_->operations) operation.in = plan_->inputs.data() + operation.first_in;
    plan_->point_at_nodes();
  }

  const FlatGraph& flat_;
  const CompileOptions& options_;
  std::unique_ptr<Plan> plan_;
  std::vector<std::size_t> place_;                     ///< [vertex] in the arena
  std::vector<std::vector<int>> read_;                 ///< [vertex]: ports that are read
  std::vector<Wire> input_lanes_;                      ///< [vertex] of an input; none: vertex -1
  std::vector<int> sources_;                           ///< [slot of Plan::inputs] the vertex that it reads
  std::map<int, int> can_rest_;                        ///< [vertex] in Plan::can_rest
  std::map<std::pair<bool, std::string>, int> paths_;  ///< [operation, path] how many so far
};

}  // namespace

std::unique_ptr<Plan> build_plan(VertexGraph graph, const FlatGraph& flat,
                                 const std::vector<OrderedSection>& sections,
                                 const std::vector<bool>& frozen_controls, const CompileOptions& options) {
  return Builder{std::move(graph), flat, options}.run(sections, frozen_controls);
}

std::optional<double> Plan::constant(const Wire& wire) const {
  const auto& vertex = vertex_of(wire);
  if (vertex.kind != Vertex::Kind::Constant) return std::nullopt;
  if (vertex.width == 1) return vertex.value;
  const auto& values = vertex.values;
  const bool same = std::count(values.begin(), values.end(), values.front()) == std::ssize(values);
  return same ? std::optional{values.front()} : std::nullopt;
}

int Plan::control_index(std::string_view control) const {
  for (std::size_t i = 0; i < controls.size(); ++i)
    if (controls[i].control.name == control) return static_cast<int>(i);
  return -1;
}

}  // namespace tactus
