#include "engine/graph/resolve.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "engine/graph/bind.h"
#include "engine/graph/nearest.h"
#include "engine/graph/quantity.h"
#include "engine/graph/scope.h"

namespace tactus {
namespace {

std::filesystem::path folder_of(const GraphSpec& spec) {
  return spec.file.file ? std::filesystem::path{*spec.file.file}.parent_path() : std::filesystem::path{};
}

/// One file at one place in the tree of parts: first all its names become signals (`declare`), parts
/// included; then what stands in its ports is bound (`connect`). Two passes, because loops name what comes
/// later.
class Instance {
 public:
  Instance(const GraphSpec& spec, const NodeTable& table, Hertz sample_rate, std::string prefix, int voices,
           FlatGraph& flat, std::vector<Error>& errors)
      : spec_(spec),
        table_(table),
        sample_rate_(sample_rate),
        prefix_(std::move(prefix)),
        voices_(voices),
        flat_(flat),
        errors_(errors) {}

  void declare_top() {
    for (const auto& input : spec_.inputs) declare_input(input);
    for (const auto& control : spec_.controls) declare_control(control);
    declare_inside();
  }

  void connect_top(const std::vector<std::string>& taps) {
    connect_inside();
    for (const auto& output : spec_.outputs) connect_output(output);
    for (const auto& tap : taps) connect_tap(tap);
  }

 private:
  struct PendingNode {
    const EntrySpec* spec;
    std::size_t flat;
  };
  struct PendingPart {
    const NodeSpec* spec;
    std::unique_ptr<Instance> instance;
  };

  void complain(Errc code, const Source& at, std::string what, std::string remedy) {
    errors_.push_back({code, at.text(), std::move(what), std::move(remedy)});
  }

  int add_signal(const std::string& name, const Source& at, FlatSignal::Kind kind, int index, int port = 0) {
    FlatSignal signal;
    signal.kind = kind;
    signal.path = prefix_ + name;
    signal.at = at;
    signal.index = index;
    signal.port = port;
    flat_.signals.push_back(std::move(signal));
    const int id = static_cast<int>(flat_.signals.size()) - 1;
    scope_.add(name, id);
    return id;
  }

  // ---- inputs and controls
  // ---------------------------------------------------------------------------------

  Dimension unit_field(const EntrySpec& entry, Unit* unit = nullptr) {
    const auto* value = find(entry.fields, "unit");
    if (value == nullptr) return {};
    const auto parsed = value->text() != nullptr ? parse_unit(*value->text()) : std::nullopt;
    if (!parsed) {
      complain(Errc::UnknownName, value->at, "'" + entry.name + "' has a unit that is not known",
               "write units as \"m/s\", \"N/m\", \"ms\", \"dB\" or \"full scale\"");
      return {};
    }
    if (unit != nullptr) *unit = *parsed;
    return parsed->dimension;
  }

  void check_keys(const EntrySpec& entry, const std::vector<std::string>& known, const std::string& owner) {
    for (const auto& field : entry.fields) {
      if (std::find(known.begin(), known.end(), field.key) != known.end()) continue;
      const auto near = nearest_name(field.key, known);
      std::string list;
      for (const auto& key : known) list += (list.empty() ? "" : ", ") + key;
      complain(Errc::UnknownName, field.at, owner + " has no '" + field.key + "'",
               near.empty() ? "it takes " + list : "did you mean '" + near + "'?");
    }
  }

  void declare_input(const EntrySpec& entry) {
    check_keys(entry, {"unit", "about", "lanes"}, "input '" + entry.name + "'");
    FlatInput input{
        .name = entry.name, .about = text_field(entry, "about"), .lanes = 1, .dimension = unit_field(entry)};
    if (const auto* lanes = find(entry.fields, "lanes")) input.lanes = whole_number(*lanes, "lanes", 1, 1024);
    const int id =
        add_signal(entry.name, entry.at, FlatSignal::Kind::Input, static_cast<int>(flat_.inputs.size()));
    flat_.signals[static_cast<std::size_t>(id)].declared = input.dimension;
    flat_.signals[static_cast<std::size_t>(id)].lanes = input.lanes;
    flat_.inputs.push_back(std::move(input));
  }

  std::string text_field(const EntrySpec& entry, const char* key) {
    const auto* value = find(entry.fields, key);
    if (value == nullptr) return {};
    if (value->text() != nullptr) return *value->text();
    complain(Errc::WrongType, value->at, std::string{"'"} + key + "' must be a string, not " + value->kind(),
             "");
    return {};
  }

  int whole_number(const Value& value, const char* what, int low, int high) {
    const auto* number = value.number();
    if (number != nullptr && std::floor(*number) == *number && *number >= low && *number <= high)
      return static_cast<int>(*number);
    complain(Errc::OutOfRange, value.at,
             std::string{"'"} + what + "' must be a whole number from " + std::to_string(low) + " to " +
                 std::to_string(high),
             "");
    return low;
  }

  FlatControl read_control(const EntrySpec& entry) {
    check_keys(entry, {"value", "range", "unit", "smooth", "taper", "about"}, "control '" + entry.name + "'");
    FlatControl control{
        .name = entry.name, .about = text_field(entry, "about"), .value = 0, .unit = {}, .range = {}};
    unit_field(entry, &control.unit);
    const auto* value = find(entry.fields, "value");
    if (value == nullptr) {
      complain(Errc::Missing, entry.at, "control '" + entry.name + "' lacks 'value'",
               "say where it starts, as in value = 0.5");
      return control;
    }
    if (const auto quantity = read_quantity(*value)) {
      control.value = quantity->si;
      if (!quantity->bare) control.unit = quantity->unit;
      control.decibel = control.unit.decibel;
    } else {
      errors_.push_back(quantity.error());
    }
    if (const auto* range = find(entry.fields, "range")) read_range(entry, *range, control);
    if (const auto* smooth = find(entry.fields, "smooth")) {
      const auto time = read_quantity(*smooth, *parse_unit("s"), "smooth");
      if (time && *time >= 0)
        control.smooth_s = *time;
      else if (!time)
        errors_.push_back(time.error());
      else
        complain(Errc::OutOfRange, smooth->at, "'smooth' cannot be negative",
                 "give a time, such as \"10 ms\"");
    }
    return control;
  }

  void read_range(const EntrySpec& entry, const Value& value, FlatControl& control) {
    const auto* list = value.list();
    if (list == nullptr || list->size() != 2)
      return complain(Errc::WrongType, value.at, "'range' of control '" + entry.name + "' must have two ends",
                      "write range = [low, high]");
    double ends[2] = {};
    for (std::size_t i = 0; i < 2; ++i) {
      const auto end = read_quantity((*list)[i], control.unit, "range");
      if (!end) return errors_.push_back(end.error());
      ends[i] = *end;
    }
    if (ends[0] > ends[1])
      return complain(Errc::OutOfRange, value.at, "'range' of control '" + entry.name + "' is upside down",
                      "write the lower end first");
    control.range = {ends[0], ends[1]};
    if (!control.range.contains(control.value))
      complain(Errc::OutOfRange, entry.at, "control '" + entry.name + "' starts outside its range",
               "move 'value' or widen 'range'");
  }

  void declare_control(const EntrySpec& entry) {
    auto control = read_control(entry);
    const int id =
        add_signal(entry.name, entry.at, FlatSignal::Kind::Control, static_cast<int>(flat_.controls.size()));
    flat_.signals[static_cast<std::size_t>(id)].declared = control.unit.dimension;
    flat_.signals[static_cast<std::size_t>(id)].range = control.range;
    flat_.controls.push_back(std::move(control));
  }

  // ---- nodes, networks, parts: names first
  // -----------------------------------------------------------------

  void declare_inside() {
    Term rate;
    rate.number = sample_rate_.value;
    rate.dimension = parse_unit("Hz")->dimension;
    rate.bare = false;
    const int system_rate = add_signal("system.rate", {}, FlatSignal::Kind::Expression, -1);
    flat_.signals[static_cast<std::size_t>(system_rate)].term = rate;
    const int delay = add_signal("system.delay", {}, FlatSignal::Kind::SystemDelay, -1);
    flat_.signals[static_cast<std::size_t>(delay)].declared = parse_unit("s")->dimension;
    flat_.signals[static_cast<std::size_t>(delay)].range = {0, 1};
    for (const auto& node : spec_.nodes) {
      if (node.value)
        add_signal(node.name, node.at, FlatSignal::Kind::Expression, -1);
      else if (!node.use.empty())
        declare_part(node);
      else
        declare_node(node);
    }
    for (const auto& network : spec_.networks) declare_network(network);
  }

  void declare_node(const NodeSpec& node) {
    const auto* type = table_.find(node.type);
    if (type == nullptr) {
      std::vector<std::string> names;
      for (const auto* known : table_.types) names.push_back(known->name);
      const auto near = nearest_name(node.type, names);
      complain(Errc::UnknownName, node.type_at, "there is no node type '" + node.type + "'",
               near.empty() ? "`tactus nodes` lists them all" : "did you mean '" + near + "'?");
      return scope_.hide(node.name);
    }
    declare_outputs(node, std::shared_ptr<const NodeType>(std::shared_ptr<void>{}, type));
  }

  void declare_network(const NetworkSpec& network) {
    auto type = table_.network ? table_.network(network) : Checked<std::shared_ptr<const NodeType>>{};
    if (!type) {
      errors_.insert(errors_.end(), type.error().begin(), type.error().end());
      return scope_.hide(network.name);
    }
    EntrySpec entry{network.name, network.at, {}};
    for (const auto& element : network.elements)
      for (const auto& field : element.fields)
        if ((*type)->input_index(element.name + "." + field.key) >= 0)
          entry.fields.push_back({element.name + "." + field.key, field.at, field.value});
    network_entries_.push_back(std::make_unique<EntrySpec>(std::move(entry)));
    scope_.explain(
        network.name,
        "name an element of the network, such as '" + network.name + "." +
            ((*type)->outputs.empty() ? std::string{"mass.position"} : (*type)->outputs.front().name) + "'");
    declare_outputs(*network_entries_.back(), *type, false);
  }

  void declare_outputs(const EntrySpec& entry, std::shared_ptr<const NodeType> type, bool bare_name = true) {
    const int index = static_cast<int>(flat_.nodes.size());
    FlatNode node;
    node.path = prefix_ + entry.name;
    node.at = entry.at;
    node.type = type;
    node.voices = voices_;
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
    if (part == spec_.parts.end()) return scope_.hide(node.name);
    int voices = voices_;
    if (const auto* value = find(node.fields, "voices")) voices = whole_number(*value, "voices", 1, 1024);
    auto instance = std::make_unique<Instance>(*part->second, table_, sample_rate_, prefix_ + node.name + ".",
                                               voices, flat_, errors_);
    instance->declare_as_part();
    for (const auto& output : part->second->outputs)
      scope_.add(node.name + "." + output.name,
                 add_signal(node.name + "." + output.name, node.at, FlatSignal::Kind::Expression, -1));
    if (part->second->outputs.size() == 1)
      scope_.add(node.name, static_cast<int>(flat_.signals.size()) - 1);
    else
      scope_.explain(node.name, "name one of its outputs, such as '" + node.name + "." +
                                    (part->second->outputs.empty() ? std::string{"output"}
                                                                   : part->second->outputs.front().name) +
                                    "'");
    part_outputs_[node.name] =
        static_cast<int>(flat_.signals.size()) - static_cast<int>(part->second->outputs.size());
    pending_parts_.push_back({&node, std::move(instance)});
  }

  void declare_as_part() {
    for (const auto& input : spec_.inputs)
      declare_binding(
          input, find(input.fields, "unit") != nullptr ? std::optional{unit_field(input)} : std::nullopt);
    for (const auto& control : spec_.controls) {
      const auto read = read_control(control);
      Term fallback;
      fallback.number = read.value;
      fallback.dimension = read.unit.dimension;
      fallback.bare = false;
      fallback.at = control.at;
      const int id = declare_binding(control, read.unit.dimension);
      flat_.signals[static_cast<std::size_t>(id)].term = fallback;
    }
    declare_inside();
  }

  int declare_binding(const EntrySpec& entry, std::optional<Dimension> declared) {
    const int id = add_signal(entry.name, entry.at, FlatSignal::Kind::Expression, -1);
    flat_.signals[static_cast<std::size_t>(id)].declared = declared;
    bindings_[entry.name] = id;
    return id;
  }

  // ---- then what stands in the ports
  // -----------------------------------------------------------------------

  void connect_inside() {
    for (const auto& node : spec_.nodes) {
      if (!node.value) continue;
      if (auto term = bind_signal(*node.value, scope_, errors_)) {
        const auto id = scope_.find(node.name, node.at);
        flat_.signals[static_cast<std::size_t>(*id)].term = std::move(*term);
      }
    }
    for (const auto& pending : pending_nodes_) connect_node(*pending.spec, flat_.nodes[pending.flat]);
    for (const auto& pending : pending_parts_) connect_part(*pending.spec, *pending.instance);
  }

  void connect_node(const EntrySpec& entry, FlatNode& node) {
    const auto& type = *node.type;
    const auto owner = type.name + " '" + entry.name + "'";
    std::vector<std::string> known = {"type", "voices", "about"};
    for (const auto& port : type.inputs) known.push_back(port.name);
    for (const auto& setting : type.settings) known.push_back(setting.name);
    check_keys(entry, known, owner);
    if (const auto* value = find(entry.fields, "voices"))
      node.voices = whole_number(*value, "voices", 1, 1024);
    for (const auto& port : type.inputs) {
      const auto* value = find(entry.fields, port.name);
      if (value != nullptr) {
        node.inputs.push_back(bind_signal(*value, scope_, errors_));
        continue;
      }
      node.inputs.emplace_back();
      if (!port.fallback) complain(Errc::Missing, entry.at, owner + " lacks '" + port.name + "'", port.doc);
    }
    for (const auto& setting : type.settings) {
      node.settings.push_back(
          bind_setting(setting, entry.fields, folder_of(spec_), owner, entry.at, errors_));
      if (setting.name == "compensate") connect_compensation(entry, node);
    }
  }

  void connect_compensation(const EntrySpec& entry, FlatNode& node) {
    const auto* value = find(entry.fields, "compensate");
    for (const auto& name : node.settings.back().names) {
      const auto known = nodes_by_name_.find(name);
      if (known != nodes_by_name_.end())
        node.compensate.push_back(known->second);
      else
        complain(Errc::UnknownName, value->at, "there is no node '" + name + "' to compensate",
                 "name nodes of this file that have a type");
    }
  }

  void connect_part(const NodeSpec& node, Instance& part) {
    const auto owner = "part '" + node.name + "'";
    std::vector<std::string> known = {"use", "voices", "about"};
    for (const auto& [name, id] : part.bindings_) known.push_back(name);
    check_keys(node, known, owner);
    for (const auto& input : part.spec_.inputs)
      if (find(node.fields, input.name) == nullptr)
        complain(Errc::Missing, node.at, owner + " lacks '" + input.name + "'", text_field(input, "about"));
    for (const auto& field : node.fields) {
      const auto binding = part.bindings_.find(field.key);
      if (binding == part.bindings_.end()) continue;
      if (auto term = bind_signal(field.value, scope_, errors_))
        flat_.signals[static_cast<std::size_t>(binding->second)].term = std::move(*term);
    }
    part.connect_inside();
    int id = part_outputs_.at(node.name);
    for (const auto& output : part.spec_.outputs)
      part.bind_output(output, flat_.signals[static_cast<std::size_t>(id++)]);
  }

  void bind_output(const EntrySpec& entry, FlatSignal& signal) {
    check_keys(entry, {"from", "kind", "unit", "about"}, "output '" + entry.name + "'");
    const auto* from = find(entry.fields, "from");
    if (from == nullptr)
      return complain(Errc::Missing, entry.at, "output '" + entry.name + "' lacks 'from'",
                      "say what it gives out, as in from = \"node\"");
    if (auto term = bind_signal(*from, scope_, errors_)) signal.term = std::move(*term);
    if (find(entry.fields, "unit") != nullptr) signal.declared = unit_field(entry);
  }

  // ---- outputs of the top file
  // -----------------------------------------------------------------------------

  void connect_output(const EntrySpec& entry) {
    FlatSignal signal;
    bind_output(entry, signal);
    FlatOutput output;
    output.name = entry.name;
    output.at = entry.at;
    output.term = std::move(signal.term);
    output.declared = signal.declared ? *signal.declared : Dimension{};
    const auto kind = text_field(entry, "kind");
    if (kind == "audio")
      output.use = OutputUse::Audio;
    else if (!kind.empty() && kind != "drive")
      complain(Errc::UnknownName, find(entry.fields, "kind")->at,
               "an output cannot be of kind '" + kind + "'", "write \"drive\" or \"audio\"");
    flat_.outputs.push_back(std::move(output));
  }

  void connect_tap(const std::string& name) {
    FlatOutput output;
    output.name = name;
    output.use = OutputUse::Tap;
    const auto signal = scope_.find(name, spec_.file);
    if (!signal) return errors_.push_back(signal.error());
    output.term.op = Term::Op::Signal;
    output.term.signal = *signal;
    flat_.outputs.push_back(std::move(output));
  }

  const GraphSpec& spec_;
  const NodeTable& table_;
  Hertz sample_rate_;
  std::string prefix_;
  int voices_;
  FlatGraph& flat_;
  std::vector<Error>& errors_;
  Scope scope_;
  std::map<std::string, int> nodes_by_name_;
  std::map<std::string, int> bindings_;      ///< a part's inputs and controls: their signals
  std::map<std::string, int> part_outputs_;  ///< a part's first output signal; the others follow
  std::vector<std::unique_ptr<EntrySpec>> network_entries_;
  std::vector<PendingNode> pending_nodes_;
  std::vector<PendingPart> pending_parts_;
};

}  // namespace

Resolved resolve(const GraphSpec& spec, const NodeTable& table, Hertz sample_rate,
                 const std::vector<std::string>& taps) {
  Resolved resolved;
  resolved.graph.signals.emplace_back().kind = FlatSignal::Kind::Missing;
  Instance top{spec, table, sample_rate, "", 1, resolved.graph, resolved.mistakes};
  top.declare_top();
  top.connect_top(taps);
  return resolved;
}

}  // namespace tactus
