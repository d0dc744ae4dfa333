#include "export/read_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "engine/graph/semantics/operators.h"
#include "export/c_names.h"
#include "export/drop_unused.h"
#include "export/kernel_texts.h"
#include "export/merge_loops.h"
#include "export/nodes/table.h"
#include "export/operators.h"
#include "export/roll_lanes.h"

namespace tactus {
namespace {

/// Longer expressions get a name, so that lines stay readable.
constexpr std::size_t kLongestInline = 70;

class PlanReader {
  using Kind = Vertex::Kind;
  using Port = std::pair<int, int>;  ///< vertex, output
  struct Check {
    Port port;
    std::string text;
  };

 public:
  PlanReader(CProgram program, const Plan& plan, const RecordedNodes& nodes)
      : program_(std::move(program)), plan_(plan), nodes_(nodes) {
    for (auto* names : {&controls_, &members_, &variables_}) names->insert(program_.name);
  }

  Checked<CProgram> run() {
    read_controls();
    find_paces();
    count_readers();
    read_inputs();
    for (const auto& step : plan_.steps) read_step(step);
    read_outputs();
    keep_checks();
    if (!errors_.empty()) return tl::unexpected(std::move(errors_));
    return std::move(program_);
  }

 private:
  const Vertex& at(int vertex) const { return plan_.vertices[index(vertex)]; }
  static std::string number(double value) { return c_number(value, *find_number_type("double")); }

  // Names.

  std::string unique(std::string_view wanted, std::set<std::string>& names) const {
    auto name = c_identifier(wanted);
    // Not as what is defined outside of functions.
    if (name.starts_with(program_.name + "_")) name = "node_" + name;
    return unique_name(name, names);
  }

  std::string name_of(const Vertex& vertex, int port, std::set<std::string>& names) const {
    const bool node = vertex.type != nullptr && port > 0;
    return unique(node ? vertex.path + "_" + vertex.type->outputs[index(port)].name : vertex.path, names);
  }
  NodeWriter::MakeName make_name() {
    return [this](const std::string& wanted, bool member) {
      return unique(wanted, member ? members_ : variables_);
    };
  }

  // What comes from outside.

  void read_controls() {
    for (const auto& planned : plan_.controls) {
      const auto& control = planned.control;
      if (planned.frozen || planned.buffer == nullptr) {
        program_.fixed_controls.push_back(control.name + " = " + in_unit(control.value, control.unit) +
                                          (planned.frozen ? "" : " (nothing reads it)"));
        control_names_.emplace_back();
        continue;
      }
      const auto smooth = static_cast<long>(std::lround(control.smooth_s * plan_.sample_rate.value));
      const auto low = in_unit(control.range.low, control.unit),
                 high = in_unit(control.range.high, control.unit);
      auto about = fmt::format("{} to {}, at first {}", low, high, in_unit(control.value, control.unit));
      if (control.unit.decibel)
        about += fmt::format("; as a factor: {:g} to {:g}, {:g}", control.range.low, control.range.high,
                             control.value);
      if (!control.about.empty()) about += "; " + control.about;
      control_names_.push_back(unique(control.name, controls_));
      program_.controls.push_back({control_names_.back(), about, control.value, control.range.low,
                                   control.range.high, smooth, control.unit.decibel});
    }
  }

  void read_inputs() {
    for (const auto& name : plan_.input_names) program_.inputs.push_back({name, {}, {}});
    for (std::size_t v = 0; v < plan_.vertices.size(); ++v) {
      const auto& vertex = plan_.vertices[v];
      if (vertex.kind != Kind::Input || readers_[v] == 0) continue;
      const auto name =
          unique(vertex.path.empty() ? plan_.input_names[index(vertex.index)] : vertex.path, variables_);
      program_.read_inputs.push_back(vertex.index);
      program_.frame.push_back(
          {fmt::format("const tactus_real {} = tactus_sample_in(in[{}]);", name, vertex.index)});
      values_[{static_cast<int>(v), 0}] = {name};
    }
  }

  /// Outputs are checked unless they are finite while all nodes are.
  void read_outputs() {
    std::vector<Check> checks;
    for (const auto& channel : plan_.channels) {
      if (channel.use == OutputUse::Tap) continue;
      auto value = value_of(channel.from).text;
      if (const Port port{channel.from.vertex, channel.from.port}; !is_finite(port)) {
        if (!is_one_word(value)) {
          const auto name = unique(channel.name, variables_);
          program_.frame.push_back({"const tactus_real " + name + " = " + value + ";"});
          value = name;
        }
        checks.push_back({port, value});
      }
      program_.frame.push_back({fmt::format("out[{}] = {};", program_.outputs.size(), value)});
      ProgramPort port{channel.name, {}, {}};
      port.audio = channel.use == OutputUse::Audio;
      program_.outputs.push_back(std::move(port));
    }
    std::ranges::move(checks, std::back_inserter(checks_));
    stays_finite_.clear();
  }

  // What changes when.

  Pace pace_of_inputs(const Vertex& vertex) const {
    Pace pace = Pace::Constant;
    for (const auto& wire : vertex.in) pace = std::max(pace, paces_[index(wire.vertex)]);
    return pace;
  }

  Pace found_pace(const Vertex& vertex) const {
    switch (vertex.kind) {
      case Kind::Constant:
      case Kind::SystemDelay:
        return Pace::Constant;
      case Kind::Control:
        return plan_.controls[index(vertex.index)].frozen ? Pace::Constant : Pace::Control;
      case Kind::Operation:
        return pace_of_inputs(vertex);
      case Kind::PhaseDelay:
        return std::max(Pace::Control, pace_of_inputs(vertex));
      case Kind::Node:
        return vertex.type->stateless ? std::max(Pace::Control, pace_of_inputs(vertex)) : Pace::Frame;
      default:
        return Pace::Frame;
    }
  }

  /// Vertices outside loops depend only on those before them in the order of the steps; what a loop gives
  /// changes from frame to frame.
  void find_paces() {
    paces_.assign(plan_.vertices.size(), Pace::Frame);
    for (std::size_t v = 0; v < plan_.vertices.size(); ++v)
      if (plan_.vertices[v].kind != Kind::Operation && plan_.vertices[v].kind != Kind::Node &&
          plan_.vertices[v].kind != Kind::PhaseDelay)
        paces_[v] = found_pace(plan_.vertices[v]);
    for_each_vertex([&](int v) { paces_[index(v)] = found_pace(at(v)); });
  }

  template <class With>
  void for_each_vertex(With with) const {
    for (const auto& step : plan_.steps) {
      if (step.kind == Step::Kind::Operations)
        for (int i = 0; i < step.operations; ++i)
          with(plan_.operations[index(step.first_operation + i)].vertex);
      else if (step.vertex >= 0)
        with(step.vertex);
    }
  }

  void count_readers() {
    readers_.assign(plan_.vertices.size(), 0);
    fast_readers_ = readers_;
    ports_.assign(plan_.vertices.size(), {});
    for (std::size_t v = 0; v < plan_.vertices.size(); ++v) {
      ports_[v].resize(index(std::max(1, plan_.vertices[v].outputs)));
      for (const auto& wire : plan_.vertices[v].in) {
        ++readers_[index(wire.vertex)];
        if (paces_[v] == Pace::Frame || plan_.vertices[v].kind == Kind::Output)
          ++fast_readers_[index(wire.vertex)];
      }
    }
    for (const auto& vertex : plan_.vertices)
      for (const auto& wire : vertex.in) ports_[index(wire.vertex)][index(wire.port)] = true;
  }

  // Values.

  std::optional<double> constant(const Wire& wire) const {
    const auto& vertex = plan_.vertex_of(wire);
    if (paces_[index(wire.vertex)] != Pace::Constant) return std::nullopt;
    if (vertex.kind == Kind::Constant) return vertex.value;
    if (vertex.kind == Kind::SystemDelay) return program_.system_delay.value;
    if (vertex.kind == Kind::Control) return plan_.controls[index(vertex.index)].control.value;
    OperandValues operands{};
    for (std::size_t i = 0; i < vertex.in.size(); ++i) operands[i] = *constant(vertex.in[i]);
    const double value = evaluate(vertex.op, operands[0], operands[1], operands[2]);
    return std::isfinite(value) ? value : 0.0;
  }

  /// The program knows the system delay, which for the engine is anything up to seconds.
  Interval range_of_wire(const Wire& wire) const {
    if (const auto value = constant(wire)) return Interval::exactly(*value);
    const auto& vertex = plan_.vertex_of(wire);
    if (vertex.kind == Kind::Control) return plan_.controls[index(vertex.index)].control.range;
    if (vertex.kind != Kind::Operation || paces_[index(wire.vertex)] == Pace::Frame) return {};
    OperandRanges ranges{};
    for (std::size_t i = 0; i < vertex.in.size(); ++i) ranges[i] = range_of_wire(vertex.in[i]);
    return range_of(operator_of(vertex.op), ranges);
  }

  CExpression value_of(const Wire& wire) const {
    if (const auto value = constant(wire)) return literal(*value);
    const auto& vertex = plan_.vertex_of(wire);
    if (vertex.kind == Kind::Control) return {"c->" + control_names_[index(vertex.index)] + ".value"};
    const auto found = values_.find({wire.vertex, wire.port});
    return found == values_.end() ? CExpression{"0.0"} : found->second;
  }
  static CExpression literal(double value) {
    return {number(value), std::signbit(value) ? CExpression::Sign : CExpression::Operand};
  }

  /// What a vertex gives, under a name: a member where it depends on controls alone, else a variable of the
  /// frame.
  void name_value(int v, int port, const CExpression& value, std::vector<std::string>& statements) {
    const auto& vertex = at(v);
    const bool member = paces_[index(v)] == Pace::Control;
    const auto name = name_of(vertex, port, member ? members_ : variables_);
    if (member) {
      program_.members.push_back({"tactus_real " + name, {}, sizeof(double)});
      statements.push_back("s->" + name + " = " + value.text + ";");
      values_[{v, port}] = {"s->" + name};
      return;
    }
    declare(v, name, value.text, statements);
    values_[{v, port}] = {name};
  }
  void declare(int v, const std::string& name, const std::string& value,
               std::vector<std::string>& statements) {
    if (at(v).divisor == 1) {
      statements.push_back("const tactus_real " + name + " = " + value + ";");
    } else {
      program_.variables.push_back("tactus_real " + name + " = 0;");
      statements.push_back(name + " = " + value + ";");
    }
  }

  void add_statements(int v, std::vector<std::string> statements) {
    for (auto& text : statements)
      if (paces_[index(v)] == Pace::Control)
        program_.follow.push_back(std::move(text));
      else
        program_.frame.push_back({std::move(text), divisor_});
  }

  // Steps.

  void read_step(const Step& step) {
    divisor_ = plan_.divisors[index(step.divider)];
    if (step.kind == Step::Kind::Operations) {
      for (int i = 0; i < step.operations; ++i)
        read_operation(plan_.operations[index(step.first_operation + i)].vertex);
      return;
    }
    const auto& vertex = at(step.vertex);
    switch (vertex.kind) {
      case Kind::Node:
        return read_node(step);
      case Kind::PhaseDelay:
        return read_phase_delay(step);
      case Kind::RateConverter:
        return read_rate_converter(step.vertex);
      default:
        return refuse(vertex, "sums of lanes that run together are not exported",
                      "compile without vectorisation");
    }
  }

  void read_operation(int v) {
    const auto& vertex = at(v);
    if (paces_[index(v)] == Pace::Constant) return;
    std::vector<CExpression> operands;
    for (const auto& wire : vertex.in) operands.push_back(value_of(wire));
    const bool divides = vertex.op == Expression::Op::Divide && constant(vertex.in[1]).value_or(0) != 0;
    auto value =
        divides ? c_quotient(operands[0], operands[1]) : c_operation(vertex.op, operands, *program_.number);
    if (has_domain(vertex.op)) value = {"tactus_finite(" + value.text + ")"};
    const bool once = readers_[index(v)] == 1 && value.text.size() < kLongestInline;
    const bool of_controls = paces_[index(v)] == Pace::Control;
    const bool short_copy = vertex.op == Expression::Op::Signal && is_one_word(value.text);
    if (short_copy || (once && !(of_controls && fast_readers_[index(v)] > 0))) {
      values_[{v, 0}] = value;
      return;
    }
    std::vector<std::string> statements;
    name_value(v, 0, value, statements);
    add_statements(v, std::move(statements));
  }

  void refuse(const Vertex& vertex, const std::string& reason, const std::string& remedy) {
    errors_.push_back(
        {Errc::BadArgument, vertex.at.text(),
         fmt::format("{} '{}' cannot be exported: {}", vertex.description(), vertex.path, reason), remedy});
  }

  NodeWriter writer_of(const Step& step, const NodeSetup& setup, const NodeExport& entry) {
    const auto& vertex = at(step.vertex);
    std::vector<WrittenInput> inputs;
    for (std::size_t i = 0; i < vertex.in.size(); ++i) {
      const auto& wire = vertex.in[i];
      const bool later = step.kind == Step::Kind::Emit && vertex.type->inputs[i].late;
      inputs.push_back({later ? CExpression{late_input(step.vertex, static_cast<int>(i))} : value_of(wire),
                        paces_[index(wire.vertex)], constant(wire), range_of_wire(wire)});
    }
    return {setup,
            entry.kernel,
            entry.state,
            node_names_.try_emplace(step.vertex, c_identifier(vertex.path)).first->second,
            std::move(inputs),
            ports_[index(step.vertex)],
            step.kind == Step::Kind::Emit,
            vertex.divisor,
            program_.recurrence,
            make_name(),
            plan_.nodes[index(step.node)].get()};
  }

  /// A node on a loop comes twice: its second half is kept until then.
  void read_node(const Step& step) {
    const auto& vertex = at(step.vertex);
    if (step.kind == Step::Kind::Absorb) return absorb(step.vertex);
    const auto* setup = nodes_.setup_of(*plan_.nodes[index(step.node)]);
    const auto* entry = setup == nullptr ? nullptr : find_node_export(setup->type->name);
    if (entry == nullptr)
      return refuse(vertex, "this type of node is not exported yet",
                    "replace it, or export the part of the graph without it");
    auto writer = writer_of(step, *setup, *entry);
    entry->write(writer);
    take(step, writer.node());
  }

  void take(const Step& step, WrittenNode& node) {
    const int v = step.vertex;
    const auto& vertex = at(v);
    if (node.refusal) return refuse(vertex, node.refusal->reason, node.refusal->remedy);
    for (auto& member : node.members) {
      member.about = vertex.path + ": " + vertex.description();
      member.where = vertex.at.text();
      program_.members.push_back(std::move(member));
    }
    std::ranges::move(node.tables, std::back_inserter(program_.tables));
    program_.table_bytes += node.table_bytes;
    std::ranges::move(node.functions, std::back_inserter(program_.functions));
    std::ranges::move(node.start, std::back_inserter(program_.start));
    std::ranges::move(node.variables, std::back_inserter(program_.variables));
    std::ranges::move(node.follow, std::back_inserter(program_.follow));
    std::ranges::move(node.design, std::back_inserter(program_.designs));
    auto statements = std::move(node.step);
    for (const bool last : {false, true})
      for (int port = 0; port < static_cast<int>(node.values.size()); ++port) {
        const bool later = std::ranges::find(node.last, port) != node.last.end();
        if (later != last || !ports_[index(v)][index(port)] || node.values[index(port)].empty()) continue;
        name_value(v, port, {node.values[index(port)]}, statements);
        if (can_stay_non_finite(vertex, port)) checks_.push_back({{v, port}, values_[{v, port}].text});
      }
    add_statements(v, std::move(statements));
    if (step.kind == Step::Kind::Emit)
      late_[v] = std::move(node.late);
    else
      add_statements(v, std::move(node.late));
  }

  static bool can_stay_non_finite(const Vertex& vertex, int port) {
    if (vertex.type == nullptr) return false;
    const auto& output = vertex.type->outputs[index(port)];
    return !vertex.type->stateless && output.kind == OutputKind::Signal && !output.range.bounded();
  }

  // Checks: a value that makes another one non-finite in the same frame needs none of its own.

  /// What many paths lead to is found once.
  template <class Value, class Find>
  static Value found_once(std::map<Port, Value>& found, const Port& port, Find find) {
    if (const auto known = found.find(port); known != found.end()) return known->second;
    return found[port] = find();
  }
  bool passes_non_finite(const Vertex& vertex, int input) const {
    using enum Expression::Op;
    if (vertex.kind == Kind::Operation)
      return vertex.op == Signal || vertex.op == Negate || vertex.op == Add || vertex.op == Subtract ||
             vertex.op == Multiply;
    const auto* entry = vertex.kind == Kind::Node ? find_node_export(vertex.type->name) : nullptr;
    return entry != nullptr && entry->passes == input;
  }
  bool is_checked(const Port& port) const {
    return std::ranges::find(checks_, port, &Check::port) != checks_.end();
  }
  /// By interval arithmetic, while what it comes from is finite; unbounded if nothing is known.
  Interval range_of_port(const Port& port) const {
    return found_once(port_ranges_, port, [&] { return find_range_of(port); });
  }
  Interval find_range_of(const Port& port) const {
    const auto& vertex = at(port.first);
    if (vertex.kind == Kind::Operation && paces_[index(port.first)] != Pace::Constant) {
      OperandRanges ranges{};
      for (std::size_t i = 0; i < vertex.in.size(); ++i)
        ranges[i] = range_of_port({vertex.in[i].vertex, vertex.in[i].port});
      return range_of(operator_of(vertex.op), ranges);
    }
    if (vertex.kind != Kind::Node) return range_of_wire({port.first, port.second});
    const auto* setup = vertex.runs < 0 ? nullptr : nodes_.setup_of(*plan_.nodes[index(vertex.runs)]);
    if (setup == nullptr) return {};
    const auto& type = *setup->type;
    return type.range ? type.range(port.second, *setup) : type.outputs[index(port.second)].range;
  }
  /// While checked values are finite.
  bool is_finite(const Port& port) const {
    const auto kind = at(port.first).kind;
    return is_checked(port) || kind == Kind::Input || kind == Kind::Control ||
           paces_[index(port.first)] == Pace::Constant || stays_finite(port);
  }
  /// While what it comes from is finite. Each loop has a checked value.
  bool stays_finite(const Port& port) const {
    return found_once(stays_finite_, port, [&] { return find_stays_finite(port); });
  }
  bool find_stays_finite(const Port& port) const {
    const auto& vertex = at(port.first);
    const auto* entry = vertex.kind == Kind::Node ? find_node_export(vertex.type->name) : nullptr;
    const bool known = vertex.kind == Kind::Operation || entry != nullptr;
    return known && ((entry != nullptr && entry->picks) || range_of_port(port).bounded()) &&
           std::ranges::all_of(vertex.in, [&](const Wire& wire) {
             return is_finite({wire.vertex, wire.port});
           });
  }
  bool reaches_check(const Port& port) const {
    return found_once(reaches_check_, port, [&] { return find_reaches_check(port); });
  }
  bool find_reaches_check(const Port& port) const {
    if (at(port.first).divisor != 1) return false;
    for (std::size_t v = 0; v < plan_.vertices.size(); ++v) {
      const auto& vertex = plan_.vertices[v];
      const Port result{static_cast<int>(v), 0};
      for (std::size_t i = 0; i < vertex.in.size(); ++i)
        if (Port{vertex.in[i].vertex, vertex.in[i].port} == port && vertex.divisor == 1 &&
            passes_non_finite(vertex, static_cast<int>(i)) && (is_checked(result) || reaches_check(result)))
          return true;
    }
    return false;
  }
  void keep_checks() {
    std::vector<Check> needed;
    std::ranges::copy_if(checks_, std::back_inserter(needed),
                         [&](const Check& check) { return !stays_finite(check.port); });
    checks_ = std::move(needed);
    for (const auto& check : checks_)
      if (!reaches_check(check.port)) program_.checked.push_back(check.text);
  }

  /// Late inputs are known only now. What goes once around a loop is checked here, where it begins anew.
  void absorb(int v) {
    auto texts = std::move(late_[v]);
    std::vector<std::string> statements;
    for (std::size_t i = 0; i < at(v).in.size(); ++i) {
      const auto placeholder = late_input(v, static_cast<int>(i));
      if (std::ranges::none_of(texts,
                               [&](const std::string& text) { return text.find(placeholder) != text.npos; }))
        continue;
      const auto value = late_value(v, at(v).in[i], statements);
      for (auto& text : texts)
        for (auto where = text.find(placeholder); where != text.npos; where = text.find(placeholder))
          text.replace(where, placeholder.size(), value);
    }
    std::ranges::move(texts, std::back_inserter(statements));
    add_statements(v, std::move(statements));
  }
  std::string late_value(int v, const Wire& wire, std::vector<std::string>& statements) {
    auto text = value_of(wire).text;
    if (paces_[index(wire.vertex)] != Pace::Frame) return text;
    if (!is_one_word(text)) {
      const auto name = unique(at(v).path + "_in", variables_);
      declare(v, name, text, statements);
      text = name;
    }
    if (std::ranges::find(checks_, text, &Check::text) == checks_.end())
      checks_.push_back({{wire.vertex, wire.port}, text});
    return text;
  }
  static std::string late_input(int v, int input) { return fmt::format("late_{}_{}__", v, input); }

  // Nodes that the compiler inserts.

  /// A time, less or more the phase delay of a filter.
  void read_phase_delay(const Step& step) {
    const auto& vertex = at(step.vertex);
    const auto& other = at(vertex.index);
    const auto* setup = other.runs < 0 ? nullptr : nodes_.setup_of(*plan_.nodes[index(other.runs)]);
    const auto* entry = setup == nullptr ? nullptr : find_node_export(setup->type->name);
    if (entry == nullptr || entry->design == nullptr)
      return refuse(vertex, "the phase delay of '" + other.path + "' is not exported",
                    "compensate for filters, or leave it out of 'compensate'");
    std::vector<WrittenInput> inputs;
    std::vector<int> all;
    for (std::size_t i = 1; i < vertex.in.size(); ++i) {
      if (i == 2) continue;  // the signal that the filter filters
      all.push_back(static_cast<int>(inputs.size()));
      inputs.push_back(
          {value_of(vertex.in[i]), paces_[index(vertex.in[i].vertex)], constant(vertex.in[i]), {}});
    }
    NodeWriter writer{*setup,
                      {},
                      {},
                      c_identifier(vertex.path + "_phase"),
                      std::move(inputs),
                      {true},
                      false,
                      vertex.divisor,
                      program_.recurrence,
                      make_name()};
    const auto phase = writer.state<double>("tactus_real", "");
    writer.when_changed(all, [&](const std::vector<std::string>& values) {
      return phase + " = tactus_phase_delay(" +
             filter_design(entry->design(*entry, *setup), {values.begin() + 1, values.end()}, writer.rate()) +
             ", " + values[0] + ", " + writer.rate() + ");";
    });
    const auto time = value_of(vertex.in[0]).within(CExpression::Sum);
    writer.give(0, time + (vertex.value < 0 ? " - " : " + ") + phase);
    take(step, writer.node());
  }

  void read_rate_converter(int v) {
    const auto& vertex = at(v);
    const auto& how = vertex.conversion;
    const bool into = vertex.divisor > how.from;
    const int ratio = into ? vertex.divisor / how.from : how.from / vertex.divisor;
    const auto in = value_of(vertex.in[0]).text;
    using How = RateConversion::How;
    CExpression value{in};
    if (!into || how.how != How::Last) {
      const auto state = unique(vertex.path + "_rate", members_);
      program_.members.push_back({std::string{into ? "tactus_gather " : "tactus_spread "} + state, {}, 24});
      const char* name = into ? (how.how == How::Smooth ? "gather_mean" : "gather_trigger")
                              : (how.how == How::Smooth ? "spread_line"
                                 : how.how == How::Last ? "spread_last"
                                                        : "spread_trigger");
      const auto fast =
          divisor_ == 1 ? std::string{"frame_number"} : fmt::format("frame_number_{}", divisor_);
      value = {fmt::format("tactus_{}(&s->{}, {}, (int)({} % {}){})", name, state, in, fast, ratio,
                           how.how == How::Smooth ? ", " + std::to_string(ratio) : "")};
    }
    std::vector<std::string> statements;
    convert(v, value, statements);
    add_statements(v, std::move(statements));
  }

  /// What goes into a part is worked out in frames outside, and what comes out of it is read there.
  void convert(int v, const CExpression& value, std::vector<std::string>& statements) {
    const auto name = name_of(at(v), 0, variables_);
    declare(v, name, value.text, statements);
    values_[{v, 0}] = {name};
  }

  CProgram program_;
  const Plan& plan_;
  const RecordedNodes& nodes_;
  std::vector<Error> errors_;
  std::set<std::string> controls_, members_, variables_;  ///< names that are taken
  std::vector<std::string> control_names_;                ///< [control]
  std::vector<Pace> paces_;                               ///< [vertex]
  std::vector<int> readers_, fast_readers_;               ///< [vertex]; those that run in each frame
  std::vector<std::vector<bool>> ports_;                  ///< [vertex] which outputs are read
  std::map<Port, CExpression> values_;
  std::vector<Check> checks_;
  mutable std::map<Port, Interval> port_ranges_;
  mutable std::map<Port, bool> stays_finite_, reaches_check_;  ///< with the checks that there are
  std::map<int, std::string> node_names_;
  std::map<int, std::vector<std::string>> late_;  ///< [vertex] its second half
  int divisor_ = 1;
};

}  // namespace

Checked<CProgram> read_plan(CProgram program, const Plan& plan, const RecordedNodes& nodes) {
  auto read = PlanReader{std::move(program), plan, nodes}.run();
  if (!read) return read;
  drop_unused(*read);
  roll_lanes(*read);
  merge_loops(*read);
  return read;
}

std::string Statement::with_loop() const {
  if (lanes == 0) return text;
  auto loop = fmt::format("for (int lane = 0; lane < {}; ++lane) {{\n  ", lanes);
  for (const char c : text) loop += c == '\n' ? std::string{"\n  "} : std::string{c};
  return loop + "\n}";
}

bool CProgram::needs_frame_number() const {
  for (const auto& statement : frame)
    if (statement.divisor > 1 || identifiers_of(statement.text).contains("frame_number")) return true;
  return false;
}

}  // namespace tactus
