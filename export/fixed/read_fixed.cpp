#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "engine/graph/file/quantity.h"
#include "engine/graph/semantics/operators.h"
#include "export/c_names.h"
#include "export/fixed/fixed_program.h"
#include "export/fixed/nodes.h"
#include "export/fixed/operators.h"

namespace tactus {
namespace {

constexpr int kPatientPasses = 8;  ///< from then on what still grows grows twice as fast
constexpr int kMostPasses = 150;
constexpr double kHuge = 1e12;  ///< what grows so far grows without limit
constexpr std::size_t kLongestOperand = 90;
constexpr double kSlack = 0.001;  ///< by which rounding exceeds an output that is limited to 1

class FixedReader {
  using Kind = Vertex::Kind;

 public:
  FixedReader(CProgram heading, int bits, const Plan& plan, const RecordedNodes& nodes,
              const InputRanges& ranges)
      : arithmetic_(bits), plan_(plan), nodes_(nodes), ranges_(ranges) {
    program_.heading = std::move(heading);
    program_.bits = bits;
  }

  Checked<FixedProgram> run() {
    read_graph();
    // Ranges and errors that depend on themselves begin with nothing and grow until they stay.
    for (pass_ = 0; pass_ < kMostPasses; ++pass_) {
      grew_ = false;
      read();
      if (!grew_) break;
    }
    const bool huge =
        std::ranges::any_of(kept_, [](const auto& entry) { return entry.second.size() > kHuge; });
    if (grew_ || huge) report_growth();
    for (auto& error : of_pass_) errors_.push_back(std::move(error));
    if (!errors_.empty()) return tl::unexpected(std::move(errors_));
    return std::move(program_);
  }

 private:
  const Vertex& at(int vertex) const { return plan_.vertices[index(vertex)]; }

  void read_graph() {
    const auto count = plan_.vertices.size();
    readers_.assign(count, 0);
    ports_.assign(count, {});
    for (std::size_t v = 0; v < count; ++v) ports_[v].resize(index(std::max(1, plan_.vertices[v].outputs)));
    for (const auto& vertex : plan_.vertices)
      for (const auto& wire : vertex.in) {
        ++readers_[index(wire.vertex)];
        ports_[index(wire.vertex)][index(wire.port)] = true;
      }
  }

  /// Whether a reader of a signal takes it with twice the bits.
  bool takes_wide(std::size_t reader, std::size_t input) const {
    using enum Expression::Op;
    const auto& vertex = plan_.vertices[reader];
    if (vertex.kind == Kind::Output) return limited(vertex.index) && !within_.contains(vertex.index);
    if (vertex.kind == Kind::Node) {
      const auto* entry = find_fixed_node(vertex.type->name);
      return entry != nullptr && entry->limits && input == 0;
    }
    if (vertex.kind != Kind::Operation) return false;
    if (vertex.op == Min || vertex.op == Max) return true;
    const bool linear = vertex.op == Signal || vertex.op == Negate || vertex.op == Add ||
                        vertex.op == Subtract || (vertex.op == Select && input > 0) ||
                        ((vertex.op == Multiply || vertex.op == Divide) && factor(vertex, input));
    return linear && wide_[reader];
  }
  bool factor(const Vertex& vertex, std::size_t input) const {
    const bool by = vertex.in.size() == 2 && plan_.constant(vertex.in[1 - input]).has_value();
    return by && (vertex.op == Expression::Op::Multiply || input == 0);
  }
  /// Outputs in full scales are limited to it: no converter gives more.
  bool limited(int channel) const { return plan_.channels[index(channel)].dimension == Dimension{}; }

  void find_wide() {
    wide_.assign(plan_.vertices.size(), true);
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t r = 0; r < plan_.vertices.size(); ++r)
        for (std::size_t i = 0; i < plan_.vertices[r].in.size(); ++i) {
          const auto v = index(plan_.vertices[r].in[i].vertex);
          if (!wide_[v] || takes_wide(r, i)) continue;
          wide_[v] = false;
          changed = true;
        }
    }
  }

  // A pass.

  void read() {
    names_.clear();
    of_pass_.clear();
    arithmetic_.decisions.clear();
    auto heading = std::move(program_.heading);
    program_ = {};
    program_.heading = std::move(heading);
    program_.bits = arithmetic_.bits();
    values_.clear();
    late_.clear();
    find_wide();
    read_controls();
    read_inputs();
    for (const auto& step : plan_.steps) read_step(step);
    read_outputs();
    program_.decisions = arithmetic_.decisions;
  }

  std::string unique(const std::string& wanted) { return unique_name(c_identifier(wanted), names_); }

  void refuse(const Source& at, std::string what, std::string remedy) {
    of_pass_.push_back({Errc::BadArgument, at.text(), std::move(what), std::move(remedy)});
  }

  void read_controls() {
    control_names_.assign(plan_.controls.size(), {});
    program_.heading.fixed_controls.clear();
    for (std::size_t c = 0; c < plan_.controls.size(); ++c) {
      const auto& control = plan_.controls[c].control;
      const bool fixed = plan_.controls[c].frozen || frozen_.contains(static_cast<int>(c)),
                 read = plan_.controls[c].buffer != nullptr;
      if (fixed || !read) {
        program_.heading.fixed_controls.push_back(control.name + " = " +
                                                  in_unit(control.value, control.unit) +
                                                  (fixed ? "" : " (nothing reads it)"));
        continue;
      }
      control_names_[c] = unique(control.name);
      if (!control.range.bounded())
        refuse({}, "control '" + control.name + "' has no range, so that its integer has no scale",
               "give it a range in the file, as in range = [0, 1]");
      FixedValue value{"s->" + control_names_[c], arithmetic_.fitting(control.range), control.range};
      value.error = 0.5 * value.step();
      program_.controls.push_back({control_names_[c], control.about, value, control.value});
      program_.members.push_back({"tactus_word " + control_names_[c], "the control within its range", 0});
      control_values_[static_cast<int>(c)] = value;
    }
  }

  void read_inputs() {
    for (std::size_t i = 0; i < plan_.input_names.size(); ++i) {
      const auto range = i < ranges_.size() && ranges_[i] ? *ranges_[i] : Interval{-1, 1};
      FixedProgram::Port port{
          plan_.input_names[i], {}, {}, {fmt::format("in[{}]", i), arithmetic_.fitting(range), range}};
      program_.inputs.push_back(port);
    }
    for (std::size_t v = 0; v < plan_.vertices.size(); ++v) {
      const auto& vertex = plan_.vertices[v];
      if (vertex.kind != Kind::Input || readers_[v] == 0) continue;
      const auto& name = plan_.input_names[index(vertex.index)];
      if (index(vertex.index) >= ranges_.size() || !ranges_[index(vertex.index)])
        refuse(vertex.at, "input '" + name + "' has no range, so that its integer has no scale",
               "give it one in [inputs], as in range = [\"-50 mm\", \"50 mm\"]");
      auto value = program_.inputs[index(vertex.index)].value;
      const auto low = arithmetic_.literal(value.range.low, value.exponent),
                 high = arithmetic_.literal(value.range.high, value.exponent);
      const auto local = unique(name);
      program_.frame.push_back(fmt::format(
          "const tactus_word {} = tactus_larger({}, tactus_smaller({}, {}));", local, low, high, value.text));
      value.text = local;
      values_[{static_cast<int>(v), 0}] = value;
    }
  }

  void read_outputs() {
    for (const auto& channel : plan_.channels) {
      if (channel.use == OutputUse::Tap) continue;
      auto value = value_of(channel.from);
      if (!value.range.bounded()) continue;
      const int number = static_cast<int>(&channel - plan_.channels.data());
      if (value.size() <= 1 + kSlack && within_.insert(number).second) grew_ = true;
      if (limited(number) && value.size() > 1) {
        arithmetic_.set_path(channel.name);
        value = arithmetic_.larger(arithmetic_.smaller(value, arithmetic_.number(1), true),
                                   arithmetic_.number(-1));
      }
      value = arithmetic_.word(value);
      if (value.constant) {
        const double constant = *value.constant;
        value.exponent = arithmetic_.fitting(value.range);
        value.text = arithmetic_.literal(constant, value.exponent);
        value.error = 0.5 * value.step();
        value.constant.reset();
      }
      FixedProgram::Port port{channel.name, {}, {}, value};
      port.audio = channel.use == OutputUse::Audio;
      program_.outputs.push_back(std::move(port));
    }
  }

  // Values.

  /// The number of what constants and controls decide, which are then fixed.
  std::optional<double> freeze(const Wire& wire) {
    const auto& vertex = plan_.vertex_of(wire);
    if (vertex.kind == Kind::Constant) return vertex.value;
    if (vertex.kind == Kind::SystemDelay) return program_.heading.system_delay.value;
    if (vertex.kind == Kind::Control) {
      if (!plan_.controls[index(vertex.index)].frozen && frozen_.insert(vertex.index).second) grew_ = true;
      return plan_.controls[index(vertex.index)].control.value;
    }
    if (vertex.kind != Kind::Operation) return std::nullopt;
    OperandValues operands{};
    for (std::size_t i = 0; i < vertex.in.size(); ++i) {
      if (!of_controls(vertex.in[i])) return std::nullopt;
      operands[i] = *freeze(vertex.in[i]);
    }
    return evaluate(vertex.op, operands[0], operands[1], operands[2]);
  }
  bool of_controls(const Wire& wire) const {
    const auto& vertex = plan_.vertex_of(wire);
    if (vertex.kind == Kind::Constant || vertex.kind == Kind::SystemDelay || vertex.kind == Kind::Control)
      return true;
    return vertex.kind == Kind::Operation &&
           std::ranges::all_of(vertex.in, [&](const Wire& in) { return of_controls(in); });
  }

  FixedValue value_of(const Wire& wire) const {
    const auto& vertex = plan_.vertex_of(wire);
    if (vertex.kind == Kind::Constant) return FixedArithmetic::number(vertex.value);
    if (vertex.kind == Kind::SystemDelay) return FixedArithmetic::number(program_.heading.system_delay.value);
    if (vertex.kind == Kind::Control) {
      const auto& control = plan_.controls[index(vertex.index)];
      if (control.frozen || frozen_.contains(vertex.index))
        return FixedArithmetic::number(control.control.value);
      return control_values_.at(vertex.index);
    }
    const auto found = values_.find({wire.vertex, wire.port});
    return found == values_.end() ? FixedArithmetic::number(0) : found->second;
  }

  static const char* type_of(const FixedValue& value) {
    return value.flag ? "unsigned char" : value.wide ? "tactus_wide" : "tactus_word";
  }

  FixedValue named(FixedValue value, const std::string& name, bool of_controls) {
    if (value.constant) return value;
    const auto local = unique(name);
    if (of_controls) {
      program_.members.push_back({fmt::format("{} {}", type_of(value), local), {}, 0});
      program_.follow.push_back(fmt::format("s->{} = {};", local, value.text));
      value.text = "s->" + local;
    } else {
      program_.frame.push_back(fmt::format("const {} {} = {};", type_of(value), local, value.text));
      value.text = local;
    }
    return value;
  }

  /// Remembers what a signal is; whether it is what it was in the pass before decides whether there is one
  /// more.
  void keep(int v, int port, const FixedValue& value) {
    const auto& vertex = at(v);
    const std::pair key{v, port};
    values_[key] = value;
    if (value.constant) return;
    if (!value.range.bounded() && bounded_inputs(vertex))
      refuse(vertex.at,
             fmt::format("the range of '{}' ({}) is not known, so that its integer has no scale", vertex.path,
                         vertex.description()),
             "limit it, or what it is made of, by clamp(…, low, high)");
    auto& before = before_[key];
    if (before.exponent != value.exponent || before.range.low != value.range.low ||
        before.range.high != value.range.high || before.error != value.error)
      grew_ = true;
    before = value;
  }
  bool bounded_inputs(const Vertex& vertex) const {
    return std::ranges::all_of(vertex.in, [&](const Wire& wire) { return value_of(wire).range.bounded(); });
  }

  // Steps.

  void read_step(const Step& step) {
    if (plan_.divisors[index(step.divider)] != 1)
      return refuse(at(step.vertex).at, "parts with a rate of their own have no form in integers yet",
                    "export with --number float");
    if (step.kind == Step::Kind::Operations) {
      for (int i = 0; i < step.operations; ++i)
        read_operation(plan_.operations[index(step.first_operation + i)].vertex);
      return;
    }
    if (at(step.vertex).kind == Kind::Node) return read_node(step);
    refuse(at(step.vertex).at, at(step.vertex).description() + " has no form in integers",
           "export with --number float");
  }

  void read_operation(int v) {
    const auto& vertex = at(v);
    arithmetic_.set_path(vertex.path);
    std::vector<FixedValue> operands;
    for (const auto& wire : vertex.in) operands.push_back(value_of(wire));
    // Whatever made a range unknown was reported there.
    const bool known =
        std::ranges::all_of(operands, [](const FixedValue& operand) { return operand.range.bounded(); });
    const auto value = known ? operation(vertex, operands, wide_[index(v)]) : std::nullopt;
    if (!value) return unknown(v);
    const bool controls = of_controls({v, 0});
    const bool inlined = readers_[index(v)] == 1 && !controls && value->text.size() < kLongestOperand;
    keep(v, 0, inlined ? *value : named(*value, vertex.path, controls));
  }

  std::optional<FixedValue> operation(const Vertex& vertex, const std::vector<FixedValue>& operands,
                                      bool wide) {
    const auto op = vertex.op;
    const auto& type = operator_of(op);
    if (std::ranges::all_of(operands, [](const FixedValue& value) { return value.constant.has_value(); })) {
      OperandValues numbers{};
      for (std::size_t i = 0; i < operands.size(); ++i) numbers[i] = *operands[i].constant;
      const double value = evaluate(op, numbers[0], numbers[1], numbers[2]);
      return FixedArithmetic::number(std::isfinite(value) ? value : 0);
    }
    if (op == Expression::Op::Mod && operands[1].constant && *operands[1].constant > 0)
      return arithmetic_.modulo(operands[0], operands[1]);
    if (op == Expression::Op::Divide && operands[1].range.contains(0) && !operands[1].constant) {
      refuse(vertex.at, fmt::format("'{}' divides by what may be 0 or has no range", vertex.path),
             "keep the divisor away from 0, as in max(…, 0.01)");
      return std::nullopt;
    }
    if (const auto* entry = find_fixed_operator(op)) return entry->write(arithmetic_, operands, wide);
    // Of one operand that changes.
    const auto changing =
        std::ranges::find_if(operands, [](const FixedValue& value) { return !value.constant; });
    const auto others =
        std::ranges::count_if(operands, [](const FixedValue& value) { return !value.constant; });
    if (others != 1) {
      refuse(vertex.at, fmt::format("'{}' of two signals has no form in integers", type.name),
             "export with --number float");
      return std::nullopt;
    }
    if (!changing->range.bounded()) return std::nullopt;
    const auto place = static_cast<std::size_t>(changing - operands.begin());
    const auto function = [&](double x) {
      OperandValues numbers{};
      for (std::size_t i = 0; i < operands.size(); ++i) numbers[i] = i == place ? x : *operands[i].constant;
      const double value = evaluate(op, numbers[0], numbers[1], numbers[2]);
      return std::isfinite(value) ? value : 0.0;
    };
    return tabulated(arithmetic_, function, *changing,
                     [&](const std::vector<std::string>& numbers) { return table(vertex.path, numbers); });
  }

  std::string declare(const std::string& type, const std::string& name, const std::string& value) {
    const auto bracket = name.find('[');
    const auto own = "tactus_" + unique(name.substr(0, bracket));
    program_.tables.push_back(fmt::format("static const {} {}{} = {};", type, own,
                                          bracket == std::string::npos ? "" : name.substr(bracket), value));
    return own;
  }
  std::string table(const std::string& path, const std::vector<std::string>& numbers) {
    std::string list;
    for (const auto& number : numbers) list += (list.empty() ? "" : ", ") + number;
    return declare("tactus_word", path + fmt::format("_table[{}] TACTUS_IN_FLASH", numbers.size()),
                   "{" + list + "}");
  }

  FixedValue late_input(int v, int input) {
    auto value = late_inputs_.contains({v, input}) ? late_inputs_.at({v, input}) : FixedValue{"0", 0, {0, 0}};
    if (!value.constant) value.text = c_identifier(at(v).path + "_" + at(v).type->inputs[index(input)].name);
    return value;
  }

  void read_node(const Step& step) {
    const int v = step.vertex;
    const auto& vertex = at(v);
    if (step.kind == Step::Kind::Absorb) return absorb(v);
    arithmetic_.set_path(vertex.path);
    const auto* setup = nodes_.setup_of(*plan_.nodes[index(step.node)]);
    const auto* entry = setup == nullptr ? nullptr : find_fixed_node(setup->type->name);
    if (entry == nullptr) {
      unknown(v);
      return refuse(vertex.at,
                    fmt::format("{} '{}' has no form in integers", vertex.description(), vertex.path),
                    "export with --number float; these have one: " + listed(fixed_node_names()));
    }
    std::vector<FixedValue> inputs;
    const bool halves = step.kind == Step::Kind::Emit;
    for (std::size_t i = 0; i < vertex.in.size(); ++i)
      inputs.push_back(halves && vertex.type->inputs[i].late ? late_input(v, static_cast<int>(i))
                                                             : value_of(vertex.in[i]));
    if (!std::ranges::all_of(inputs, [](const FixedValue& input) { return input.range.bounded(); }))
      return unknown(v);
    std::vector<std::string> late;
    FixedNode node{*setup, arithmetic_, inputs, ports_[index(v)], wide_[index(v)], around(v, late)};
    entry->write(node);
    for (int port = 0; port < static_cast<int>(node.values.size()); ++port)
      if (ports_[index(v)][index(port)]) {
        const auto& value = node.values[index(port)];
        const bool inlined = readers_[index(v)] == 1 && value.text.size() < kLongestOperand;
        keep(v, port,
             inlined
                 ? value
                 : named(value,
                         port == 0 ? vertex.path : vertex.path + "_" + vertex.type->outputs[index(port)].name,
                         false));
      }
    if (halves)
      late_[v] = std::move(late);
    else
      std::ranges::move(late, std::back_inserter(program_.frame));
  }

  void unknown(int v) {
    for (int port = 0; port < at(v).outputs; ++port) {
      FixedValue value{"0", 0, {}};
      values_[{v, port}] = value;
    }
  }

  void absorb(int v) {
    const auto& vertex = at(v);
    for (int i = 0; i < static_cast<int>(vertex.in.size()); ++i) {
      if (!vertex.type->inputs[index(i)].late) continue;
      auto value = arithmetic_.word(value_of(vertex.in[index(i)]));
      auto& before = late_inputs_[{v, i}];
      if (before.exponent != value.exponent || before.range.low != value.range.low ||
          before.range.high != value.range.high || before.flag != value.flag)
        grew_ = true;
      before = value;
      if (!value.constant) {
        const auto name = late_input(v, i).text;
        program_.frame.push_back(fmt::format("const {} {} = {};", type_of(value), name, value.text));
      }
    }
    std::ranges::move(late_[v], std::back_inserter(program_.frame));
  }

  FixedNode::Around around(int v, std::vector<std::string>& late) {
    const auto& vertex = at(v);
    FixedNode::Around result;
    result.state = [&](const std::string& type, const std::string& suffix, int count) {
      const auto name = unique(suffix.empty() ? vertex.path : vertex.path + "_" + suffix);
      program_.members.push_back(
          {fmt::format("{} {}{}", type, name, count > 0 ? fmt::format("[{}]", count) : ""),
           vertex.path + ": " + vertex.description(), 0});
      return "s->" + name;
    };
    result.local = [&](const FixedValue& value, const std::string& suffix) {
      return named(value, vertex.path + "_" + suffix, false);
    };
    result.start = [&](std::string text) { program_.start.push_back(std::move(text)); };
    result.step = [&](std::string text) { program_.frame.push_back(std::move(text)); };
    result.late = [&](std::string text) { late.push_back(std::move(text)); };
    result.table = [&](const std::vector<std::string>& numbers) { return table(vertex.path, numbers); };
    result.declare = [&](const std::string& type, const std::string& suffix, const std::string& value) {
      return declare(type, vertex.path + "_" + suffix, value);
    };
    result.freeze = [this, &vertex](int input) { return freeze_input(vertex, input); };
    result.refuse = [&](const std::string& reason, const std::string& remedy) {
      refuse(vertex.at,
             fmt::format("{} '{}' has no form in integers: {}", vertex.description(), vertex.path, reason),
             remedy);
    };
    result.kept = [this, v](Interval range, double error) { return kept(v, range, error); };
    return result;
  }

  std::optional<double> freeze_input(const Vertex& vertex, int input) {
    const auto& wire = vertex.in[index(input)];
    return of_controls(wire) ? freeze(wire) : std::nullopt;
  }

  FixedValue kept(int v, Interval range, double error) {
    auto& state = kept_[v];
    const auto joined = state.range.joined(range);
    // No error is larger than all values together.
    const double most = std::max(state.error, std::min(error, joined.high - joined.low));
    if (joined.low != state.range.low || joined.high != state.range.high || most != state.error) {
      grew_ = true;
      growing_.insert(v);
      const double faster =
          pass_ < kPatientPasses ? 0 : std::ldexp(1.0, std::min(60, pass_ - kPatientPasses)) - 0.5;
      const double up = joined.high - state.range.high, down = state.range.low - joined.low,
                   further = most - state.error;
      state.range = {joined.low - faster * down, joined.high + faster * up};
      state.error = most + faster * further;
    }
    return state;
  }

  void report_growth() {
    of_pass_.clear();
    for (const int v : growing_)
      if (kept_[v].size() > kHuge)
        refuse(at(v).at,
               fmt::format("'{}' may grow without limit, so that its integer has no scale", at(v).path),
               "limit what it takes over, as in clamp(…, low, high)");
    if (of_pass_.empty())
      of_pass_.push_back({Errc::BadArgument, "", "the ranges of the signals do not settle",
                          "limit signals on loops by clamp(…, low, high)"});
  }

  FixedProgram program_;
  FixedArithmetic arithmetic_;
  const Plan& plan_;
  const RecordedNodes& nodes_;
  const InputRanges& ranges_;
  int pass_ = 0;
  bool grew_ = false;
  std::vector<Error> errors_, of_pass_;
  std::vector<int> readers_;              ///< [vertex]
  std::vector<std::vector<bool>> ports_;  ///< [vertex] which outputs are read
  std::vector<bool> wide_;                ///< [vertex]
  std::set<std::string> names_;
  std::set<int> frozen_, growing_, within_;
  std::vector<std::string> control_names_;
  std::map<int, FixedValue> control_values_, kept_;
  std::map<std::pair<int, int>, FixedValue> values_, before_, late_inputs_;
  std::map<int, std::vector<std::string>> late_;
};

}  // namespace

Checked<FixedProgram> read_fixed(CProgram heading, int bits, const Plan& plan, const RecordedNodes& nodes,
                                 const InputRanges& ranges) {
  return FixedReader{std::move(heading), bits, plan, nodes, ranges}.run();
}

}  // namespace tactus
