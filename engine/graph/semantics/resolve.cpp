#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <unordered_map>

#include "engine/core/named.h"
#include "engine/graph/file/read_graph.h"
#include "engine/graph/semantics/facts.h"
#include "engine/graph/semantics/scope.h"

namespace tactus {
namespace {

/// How a part runs at a fraction of the rate around it:
///
///   loop = { use = "loop.toml", rate = "1/16", take = "mean", between = "line", … }
struct PartRate {
  using How = RateConversion::How;
  static constexpr int kSlowest = 1024;
  int ratio = 1;            ///< frames around it for one of its own
  How take = How::Last;     ///< its inputs; Smooth: means of the frames since its last one
  How between = How::Last;  ///< its outputs; Smooth: straight from one sample to the next
};

std::string owner_of(const NodeSpec& part) { return "part '" + part.name + "'"; }

/// Whether an input or a control of the part is called like this.
bool declares(const GraphSpec& part, std::string_view name) {
  return find_named(part.inputs, name) != nullptr || find_named(part.controls, name) != nullptr;
}

std::string in_hertz(double hertz) { return short_quantity(hertz, parse_unit("Hz")->dimension); }

/// The fractions on both sides of a rate that is none.
std::string nearest_rates(double around, double ratio) {
  const auto offer = [&](double n) { return "\"1/" + short_number(n) + "\" (" + in_hertz(around / n) + ")"; };
  const double below = std::max(1.0, std::floor(ratio));
  return "write " + offer(below) + " or " + offer(below + 1);
}

/// Frames around a part for one of its own; 1 after an error.
int read_ratio(const Value& value, Hertz around, const std::string& owner, ErrorList& errors) {
  const auto report = [&](Errc code, const std::string& what, const std::string& remedy) {
    errors.add(code, value.at, key_of("rate", owner) + what, remedy);
    return 1;
  };
  std::string text = value.text() != nullptr ? *value.text() : "";
  std::erase(text, ' ');
  const auto below_one = text.starts_with("1/") ? parse_quantity(text.substr(2)) : std::nullopt;
  double ratio = below_one ? below_one->si : 0;
  if (!below_one || !below_one->bare) {
    const auto quantity = read_quantity(value);
    if (!quantity || quantity->bare || !(quantity->unit.dimension == parse_unit("Hz")->dimension))
      return report(Errc::WrongType, " is not a rate",
                    "write a fraction such as \"1/16\", or a rate such as \"3 kHz\"");
    if (!(quantity->si > 0) || quantity->si > around.value)
      return report(
          Errc::OutOfRange, " cannot be " + in_hertz(quantity->si),
          "the rate of a part must not exceed the " + in_hertz(around.value) + " of the enclosing graph");
    ratio = around.value / quantity->si;
  }
  const double whole = std::round(ratio);
  // Rates come as decimal numbers: 44.1 kHz / 14.7 kHz is 3 but for rounding.
  if (std::abs(ratio - whole) > 1e-9 * ratio || whole < 1)
    return report(
        Errc::OutOfRange,
        " is not the " + in_hertz(around.value) + " of the enclosing graph divided by a whole number",
        nearest_rates(around.value, ratio));
  if (whole <= PartRate::kSlowest) return static_cast<int>(whole);
  return report(Errc::OutOfRange, " is too low",
                "give at least \"1/" + std::to_string(PartRate::kSlowest) + "\"");
}

/// `rate`, `take` and `between` of a part; `around` is the rate of the file that uses it.
PartRate read_part_rate(const NodeSpec& node, const GraphSpec& part, Hertz around, ErrorList& errors) {
  Value::Table own = node.fields;
  std::erase_if(own, [&](const Field& field) { return declares(part, field.key); });
  FieldReader fields{own, part_fields().fields, errors, FieldReader::kKeysChecked, owner_of(node)};
  const auto second_choice = [&](const char* key) {
    const auto choice = fields.choice(key);
    if (choice && !fields.has("rate"))
      errors.add(Errc::Missing, fields.value(key)->at,
                 key_of(key, owner_of(node)) + " has no effect without a 'rate'",
                 "give the part its own rate, or remove '" + std::string{key} + "'");
    return choice == 1 ? PartRate::How::Smooth : PartRate::How::Last;
  };
  PartRate rate;
  if (const auto* value = fields.value("rate"))
    rate.ratio = read_ratio(*value, around, owner_of(node), errors);
  rate.take = second_choice("take");
  rate.between = second_choice("between");
  return rate;
}

/// What all files of a tree of parts share while their names are looked up.
struct Resolving {
  const NodeTable& table;
  Hertz sample_rate;
  FlatGraph& flat;
  std::vector<PartRange>& part_ranges;
  ErrorList& errors;
  std::size_t most_signals;  ///< parts of parts multiply: 32 files that use the next one twice make 2^32
};

/// One file at one place in the tree of parts: first all its names become signals (`declare`), parts
/// included; then its ports are bound (`connect`). Two passes, because loops name what comes later.
class Instance {
 public:
  /// `prefix` ("bridge.") precedes its names in the whole graph; `voices` is how many lanes its user
  /// wants. `outer_divisor` is the rate divisor of the file that uses it.
  Instance(const GraphSpec& spec, Resolving& resolving, std::string prefix, int voices, int outer_divisor = 1,
           PartRate rate = {})
      : spec_(spec),
        resolving_(resolving),
        flat_(resolving.flat),
        errors_(resolving.errors),
        prefix_(std::move(prefix)),
        voices_(voices),
        outer_divisor_(outer_divisor),
        divisor_(outer_divisor * rate.ratio),
        rate_(rate) {
    if (spec.incomplete) scope_.tolerate("");
  }

  void declare_top() {
    for (const auto& input : spec_.inputs) declare_input(input);
    for (const auto& control : spec_.controls) declare_control(control);
    declare_inside();
  }
  void connect_top(const std::vector<std::string>& taps) {
    connect_inside();
    for (const auto& output : spec_.outputs)
      if (!output.broken) connect_output(output);
    for (const auto& tap : taps) connect_tap(tap);
    warn_of_unread();
  }

 private:
  struct PendingNode {
    const EntrySpec* spec;
    std::size_t flat;
  };
  struct PendingPart {
    const NodeSpec* spec;
    std::unique_ptr<Instance> instance;
    int first_output;  ///< its signal; those of the other outputs follow
  };

  Hertz sample_rate() const { return Hertz{resolving_.sample_rate.value / divisor_}; }
  FlatSignal& signal(int id) { return flat_.signals[index(id)]; }
  std::filesystem::path folder() const {
    return std::filesystem::path{spec_.file.file ? *spec_.file.file : std::string{}}.parent_path();
  }

  int add_signal(const std::string& name, const Source& at, FlatSignal::Kind kind, int index, int port = 0) {
    flat_.signals.push_back({kind, prefix_ + name, at, index, port, {}, {}, divisor_});
    const int id = static_cast<int>(flat_.signals.size()) - 1;
    scope_.add(name, id);
    return id;
  }

  int add_expression(const std::string& name, const Source& at) {
    const int id = add_signal(name, at, FlatSignal::Kind::Expression, -1);
    signal(id).expression = missing_signal(at);  // until it is connected
    return id;
  }

  void declare_input(const PortSpec& input) {
    const int id = add_signal(input.name, input.at, FlatSignal::Kind::Input, -1);
    if (input.unit_known) signal(id).declared = input.dimension;
    signal(id).lanes = input.lanes;
    if (input.broken) scope_.hide(input.name);
  }

  void declare_control(const ControlSpec& entry) {
    if (entry.broken) return scope_.hide(entry.name);
    const int id =
        add_signal(entry.name, entry.at, FlatSignal::Kind::Control, static_cast<int>(flat_.controls.size()));
    if (entry.unit_known) signal(id).declared = entry.control.unit.dimension;
    signal(id).range = entry.control.range;
    flat_.controls.push_back(entry.control);
  }

  void declare_system() {
    const int rate = add_signal("system.rate", {}, FlatSignal::Kind::SystemRate, -1);
    signal(rate).declared = parse_unit("Hz")->dimension;
    signal(rate).range = Interval::exactly(sample_rate().value);
    const int delay = add_signal("system.delay", {}, FlatSignal::Kind::SystemDelay, -1);
    signal(delay).declared = parse_unit("s")->dimension;
    signal(delay).range = {0, 1};
  }

  void declare_inside() {
    declare_system();
    for (const auto& node : spec_.nodes) {
      if (node.broken)
        scope_.hide(node.name);
      else if (node.value)
        add_expression(node.name, node.at);
      else if (!node.use.empty())
        declare_part(node);
      else
        declare_node(node);
    }
    for (const auto& network : spec_.networks) declare_network(network);
  }

  void declare_node(const NodeSpec& node) {
    const auto& table = resolving_.table;
    const auto* type = table.find(node.type);
    if (type != nullptr) {
      check_keys(node, *type);
      return declare_outputs(node, std::shared_ptr<const NodeType>(std::shared_ptr<void>{}, type), true);
    }
    std::vector<std::string> names;
    for (const auto* known : table.types) names.push_back(known->name);
    const auto other = table.other_name ? table.other_name(node.type) : std::string{};
    errors_.add(Errc::UnknownName, node.type_at, "there is no node type '" + node.type + "'",
                other.empty() ? suggest(node.type, names, "`tactus nodes` lists them all") : other);
    scope_.hide(node.name);
  }

  void check_keys(const NodeSpec& node, const NodeType& type) {
    auto known = node_fields().keys();
    for (const auto& port : type.inputs) known.push_back(port.name);
    for (const auto& setting : type.settings) known.push_back(setting.name);
    errors_.unknown_keys(node.fields, known, type.name + " '" + node.name + "'");
  }

  void declare_network(const NetworkSpec& network) {
    auto type = resolving_.table.network ? resolving_.table.network(network)
                                         : Checked<std::shared_ptr<const NodeType>>{};
    if (!type) {
      errors_.add(std::move(type.error()));
      return scope_.hide(network.name);
    }
    EntrySpec entry{network.name, network.at, {}};
    for (const auto& element : network.elements) {
      const auto controls = declare_remote(network, element, **type);
      for (const auto& field : element.fields)
        if (find(controls, element.name + "." + field.key) == nullptr)
          entry.fields.push_back({element.name + "." + field.key, field.at, field.value});
      entry.fields.insert(entry.fields.end(), controls.begin(), controls.end());
    }
    network_entries_.push_back(std::make_unique<EntrySpec>(std::move(entry)));
    const auto& outputs = (*type)->outputs;
    scope_.explain(network.name, std::string{"write an element of the "} + network.kind() + ", such as '" +
                                     network.name + "." +
                                     (outputs.empty() ? "mass.position" : outputs.front().name) + "'");
    declare_outputs(*network_entries_.back(), *type, false);
  }

  /// The controls of an element of a world with `remote`, and the fields that read them: each signal that is
  /// a number in the file, or left out. Those of parts stay numbers.
  Value::Table declare_remote(const NetworkSpec& world, const NodeSpec& element, const NodeType& type) {
    Value::Table read;
    const auto* remote = world.world ? find(element.fields, "remote") : nullptr;
    if (remote == nullptr || remote->text() == nullptr || *remote->text() != "yes" || !prefix_.empty())
      return read;
    for (const auto& port : type.inputs) {
      if (port.fixed || !port.name.starts_with(element.name + ".")) continue;
      const auto field = port.name.substr(element.name.size() + 1);
      const auto* given = find(element.fields, field);
      const auto unit = parse_unit(port.unit).value_or(Unit{});
      const auto initial =
          given != nullptr
              ? read_quantity(*given, unit, field).map([](double si) { return std::optional{si}; })
              : Result<std::optional<double>>{port.fallback};
      if (!initial || !*initial) continue;
      ControlSpec control{{world.name + "_" + element.name + "_" + field, element.at, {}}, {}, true};
      control.control = {.name = control.name, .value = **initial, .unit = unit, .smooth_s = 0};
      control.control.range = {port.low, port.high};
      control.control.about = port.doc;
      declare_control(control);
      read.push_back({port.name, element.at, Value{control.name, element.at}});
    }
    return read;
  }

  void declare_outputs(const EntrySpec& entry, std::shared_ptr<const NodeType> type, bool bare_name) {
    const int index = static_cast<int>(flat_.nodes.size());
    FlatNode node{prefix_ + entry.name, entry.at, type};
    // A sum adds the lanes that there are, in a part with voices too.
    node.voices = type->reduces_lanes ? 1 : voices_;
    node.divisor = divisor_;
    for (std::size_t port = 0; port < type->outputs.size(); ++port) {
      const int id = add_signal(entry.name + "." + type->outputs[port].name, entry.at,
                                FlatSignal::Kind::NodeOutput, index, static_cast<int>(port));
      if (port == 0 && bare_name) scope_.add(entry.name, id);
      node.outputs.push_back(id);
    }
    nodes_by_name_[entry.name] = index;
    pending_nodes_.push_back({&entry, flat_.nodes.size()});
    flat_.nodes.push_back(std::move(node));
  }

  void declare_part(const NodeSpec& node) {
    const auto part = spec_.parts.find(node.use);
    if (part == spec_.parts.end()) return scope_.hide(node.name);  // its file cannot be read
    if (too_large(node)) return scope_.hide(node.name);
    FieldReader fields{node.fields, part_fields().fields, errors_, FieldReader::kKeysChecked, owner_of(node)};
    const int voices = static_cast<int>(fields.number("voices").value_or(voices_));
    const auto rate = read_part_rate(node, *part->second, sample_rate(), errors_);
    auto instance = std::make_unique<Instance>(*part->second, resolving_, prefix_ + node.name + ".", voices,
                                               divisor_, rate);
    instance->declare_as_part();
    const int first_output = static_cast<int>(flat_.signals.size());
    declare_part_outputs(node, *part->second, *instance);
    pending_parts_.push_back({&node, std::move(instance), first_output});
  }

  bool too_large(const NodeSpec& node) {
    if (flat_.signals.size() < resolving_.most_signals) return false;
    if (!std::exchange(flat_.too_large, true))
      errors_.add(Errc::OutOfRange, node.type_at,
                  "the parts contain more than " + std::to_string(resolving_.most_signals) + " signals",
                  "use fewer nested parts");
    return true;
  }

  void declare_part_outputs(const NodeSpec& node, const GraphSpec& part, const Instance& instance) {
    for (const auto& output : part.outputs) {
      const int id = add_expression(node.name + "." + output.name, node.at);
      if (instance.divisor_ != divisor_) signal(id).conversion = {instance.divisor_, instance.rate_.between};
    }
    if (part.outputs.size() == 1)
      scope_.add(node.name, static_cast<int>(flat_.signals.size()) - 1);
    else
      scope_.explain(node.name, "write one of its outputs, such as '" + node.name + "." +
                                    (part.outputs.empty() ? "output" : part.outputs.front().name) + "'");
    if (part.incomplete) scope_.tolerate(node.name);
  }

  /// What a part is given: it comes from the rate around the part into its own.
  int declare_binding(const EntrySpec& entry) {
    const int id = add_expression(entry.name, entry.at);
    bindings_[entry.name] = id;
    if (divisor_ != outer_divisor_) signal(id).conversion = {outer_divisor_, rate_.take};
    return id;
  }

  void declare_as_part() {
    for (const auto& input : spec_.inputs) {
      const int id = declare_binding(input);
      signal(id).declared = input.declared();
    }
    for (const auto& entry : spec_.controls) {
      const int id = declare_binding(entry);
      if (!entry.unit_known) continue;
      const auto& control = entry.control;
      signal(id).declared = control.unit.dimension;
      signal(id).expression = number_expression(control.value, control.unit.dimension, false, entry.at);
    }
    declare_inside();
  }

  void connect_inside() {
    for (const auto& node : spec_.nodes) {
      if (!node.value) continue;
      auto expression = bind_signal(*node.value, scope_, errors_);
      if (const auto id = scope_.find(node.name, node.at); id && *id != FlatGraph::kMissing)
        signal(*id).expression = std::move(expression);
    }
    for (const auto& pending : pending_nodes_) connect_node(*pending.spec, flat_.nodes[pending.flat]);
    for (const auto& pending : pending_parts_) connect_part(pending);
  }

  void connect_node(const EntrySpec& entry, FlatNode& node) {
    const auto owner = node.label();
    FieldReader fields{entry.fields, node_fields().fields, errors_, FieldReader::kKeysChecked, owner};
    if (const auto voices = fields.number("voices")) node.voices = static_cast<int>(*voices);
    connect_ports(entry, node, owner);
    for (const auto& setting : node.type->settings) {
      node.settings.push_back(bind_setting(setting, entry.fields, folder(), owner, entry.at, errors_));
      if (setting.kind == Setting::Kind::Names) connect_compensation(entry, setting.name, node);
    }
  }

  void connect_ports(const EntrySpec& entry, FlatNode& node, const std::string& owner) {
    std::unordered_map<std::string_view, const Value*> given;  // networks have thousands
    for (const auto& field : entry.fields) given.emplace(field.key, &field.value);
    for (const auto& port : node.type->inputs) {
      if (const auto value = given.find(port.name); value != given.end()) {
        node.inputs.push_back(bind_signal(*value->second, scope_, errors_));
        continue;
      }
      node.inputs.emplace_back();
      if (!port.fallback)
        errors_.add(Errc::Missing, entry.at, owner + " lacks '" + port.name + "'",
                    "write " + port.name + " = … (" + port.doc + ")");
    }
  }

  void connect_compensation(const EntrySpec& entry, const std::string& field, FlatNode& node) {
    const auto* value = find(entry.fields, field);
    std::set<std::string> named;
    for (const auto& name : node.settings.back().names) {
      if (!named.insert(name).second) {
        errors_.add(Errc::BadArgument, value->at, "'" + name + "' is compensated twice", "list it once");
        continue;
      }
      const auto known = nodes_by_name_.find(name);
      if (known != nodes_by_name_.end()) {
        if (name == entry.name || flat_.nodes[index(known->second)].type->resonant)
          errors_.add(Errc::BadArgument, value->at,
                      "'" + name + "' cannot be compensated: it is not a filter",
                      "omit it; list only nodes that change the phase");
        node.compensate.push_back(known->second);
        compensated_.insert(known->second);
      } else if (scope_.find(name, value->at) != FlatGraph::kMissing) {
        errors_.add(
            Errc::UnknownName, value->at, "there is no node '" + name + "' to compensate",
            "list nodes that this file declares with 'type'; expressions and parts cannot be compensated");
      }
    }
  }

  void check_part_fields(const NodeSpec& node, const Instance& part) {
    const auto owner = owner_of(node);
    auto known = part_fields().keys();
    std::erase_if(known, [&](const std::string& key) { return part.bindings_.contains(key); });
    for (const auto& [name, id] : part.bindings_) known.push_back(name);
    if (!part.spec_.incomplete) errors_.unknown_keys(node.fields, known, owner);
    for (const auto& input : part.spec_.inputs) {
      if (find(node.fields, input.name) != nullptr) continue;
      const auto* about = find(input.fields, "about");
      errors_.add(Errc::Missing, node.at, owner + " lacks '" + input.name + "'",
                  about != nullptr && about->text() != nullptr
                      ? *about->text()
                      : "it is an input of " + *part.spec_.file.file);
    }
  }

  void connect_part(const PendingPart& pending) {
    auto& part = *pending.instance;
    check_part_fields(*pending.spec, part);
    for (const auto& field : pending.spec->fields) {
      const auto binding = part.bindings_.find(field.key);
      if (binding == part.bindings_.end()) continue;
      auto& bound = signal(binding->second);
      bound.expression = bind_signal(field.value, scope_, errors_);
      // Nothing else determines over how many lanes it is spread.
      if (bound.expression.op == Expression::Op::Spread) bound.lanes = part.voices_;
    }
    add_part_ranges(*pending.spec, part);
    part.connect_inside();
    int id = pending.first_output;
    for (const auto& output : part.spec_.outputs) {
      if (!output.broken) {
        signal(id).expression = part.bind_output(output);
        signal(id).declared = output.declared();
      }
      ++id;
    }
    part.warn_of_unread();
  }

  /// Of what the part is given. The ±1 of an input in full scale is no range that its file declares.
  void add_part_ranges(const NodeSpec& node, const Instance& part) {
    const auto add = [&](const EntrySpec& entry, Interval range, const Unit& unit, bool whole) {
      if (find(node.fields, entry.name) != nullptr)
        resolving_.part_ranges.push_back(
            {part.bindings_.at(entry.name), range, unit, key_of(entry.name, owner_of(node)), whole});
    };
    for (const auto& input : part.spec_.inputs)
      if (input.range && find(input.fields, "range") != nullptr)
        add(input, *input.range, Unit{input.dimension}, false);
    for (const auto& entry : part.spec_.controls)
      if (entry.unit_known) add(entry, entry.control.range, entry.control.unit, takes_whole_numbers(entry));
  }

  /// What nothing in this file reads. A trigger is read by whoever records its events. (A scene gives its
  /// plant inputs with dots in their names.)
  void warn_of_unread() {
    const auto warn = [this](const std::string& what, const EntrySpec& entry, const char* remedy) {
      errors_.warn(Errc::UnknownName, entry.at, what + " '" + entry.name + "' is not used", remedy);
    };
    for (const auto& input : spec_.inputs)
      if (!input.broken && is_name(input.name) && !scope_.is_read(input.name))
        warn("input", input, "use it in a node or an output, or remove it");
    for (const auto& control : spec_.controls)
      if (!control.broken && !scope_.is_read(control.name))
        warn("control", control, "use it in a node or an output, or remove it");
    for (const auto& node : spec_.nodes)
      if (node.value ? !scope_.is_read(node.name) : is_unread_node(node.name))
        warn("node", node, "connect it to an output, or remove it");
  }

  bool is_unread_node(const std::string& name) const {
    const auto known = nodes_by_name_.find(name);
    if (known == nodes_by_name_.end()) return false;
    if (compensated_.contains(known->second)) return false;
    const auto& node = flat_.nodes[index(known->second)];
    for (const int id : node.outputs) {
      const auto& port = node.type->outputs[index(flat_.signals[index(id)].port)];
      if (port.kind == OutputKind::Trigger || scope_.is_read(id)) return false;
    }
    return true;
  }

  Expression bind_output(const PortSpec& output) {
    const auto* from = find(output.fields, "from");
    if (from != nullptr) return bind_signal(*from, scope_, errors_);
    errors_.add(Errc::Missing, output.at, "output '" + output.name + "' lacks 'from'",
                "give its source, as in from = \"node\"");
    return missing_signal(output.at);
  }

  void connect_output(const PortSpec& port) {
    FlatOutput output{port.name, port.use, bind_output(port), port.at};
    // A drive is a plain number unless the file gives another unit; a wrong unit is unknown.
    if (port.unit_known) output.declared = port.dimension;
    flat_.outputs.push_back(std::move(output));
  }

  void connect_tap(const std::string& name) {
    const auto found = scope_.find(name, spec_.file);
    if (errors_.keep(found) == nullptr) return;
    FlatOutput output{name, OutputUse::Tap, missing_signal({})};
    output.expression.signal = *found;
    flat_.outputs.push_back(std::move(output));
  }

  const GraphSpec& spec_;
  Resolving& resolving_;
  FlatGraph& flat_;
  ErrorList& errors_;
  std::string prefix_;
  int voices_;
  int outer_divisor_, divisor_;  ///< engine frames between two of its user's, and of its own
  PartRate rate_;
  Scope scope_;
  std::map<std::string, int> nodes_by_name_;
  std::set<int> compensated_;            ///< nodes that a setting names
  std::map<std::string, int> bindings_;  ///< a part's inputs and controls: their signals
  std::vector<std::unique_ptr<EntrySpec>> network_entries_;
  std::vector<PendingNode> pending_nodes_;
  std::vector<PendingPart> pending_parts_;
};

}  // namespace

Resolved resolve(const GraphSpec& spec, const NodeTable& table, Hertz sample_rate, ErrorList& errors,
                 const std::vector<std::string>& taps, std::size_t most_signals) {
  Resolved resolved;
  resolved.graph.signals.emplace_back().kind = FlatSignal::Kind::Missing;
  Resolving resolving{table, sample_rate, resolved.graph, resolved.part_ranges, errors, most_signals};
  Instance top{spec, resolving, "", 1};
  top.declare_top();
  top.connect_top(taps);
  return resolved;
}

}  // namespace tactus
