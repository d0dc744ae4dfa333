#include <algorithm>
#include <unordered_set>
#include <utility>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/read_graph.h"
#include "engine/graph/semantics/instance.h"
#include "engine/graph/semantics/scope.h"

namespace tactus {

Instance::Instance(const GraphSpec& spec, Resolving& resolving, std::string prefix, int voices,
                   int outer_divisor, PartRate rate)
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

int Instance::add_signal(const std::string& name, const Source& at, FlatSignal::Kind kind, int index,
                         int port) {
  FlatSignal added;
  added.kind = kind;
  added.path = prefix_ + name;
  added.at = at;
  added.index = index;
  added.port = port;
  added.divisor = divisor_;
  flat_.signals.push_back(std::move(added));
  const int id = static_cast<int>(flat_.signals.size()) - 1;
  scope_.add(name, id);
  return id;
}

int Instance::add_expression(const std::string& name, const Source& at) {
  const int id = add_signal(name, at, FlatSignal::Kind::Expression, -1);
  signal(id).expression = missing_signal(at);  // until it is connected
  return id;
}

void Instance::declare_top() {
  for (const auto& input : spec_.inputs) declare_input(input);
  for (const auto& control : spec_.controls) declare_control(control);
  tested_delays(spec_, errors_);
  declare_inside();
}

void Instance::declare_input(const EntrySpec& entry) {
  auto input = read_input(entry, errors_);
  const auto unit = read_unit(entry, errors_);
  const int id =
      add_signal(entry.name, entry.at, FlatSignal::Kind::Input, static_cast<int>(flat_.inputs.size()));
  if (unit) {
    input.dimension = unit->dimension;
    signal(id).declared = unit->dimension;
  }
  signal(id).lanes = input.lanes;
  flat_.inputs.push_back(std::move(input));
  if (entry.broken) scope_.hide(entry.name);
}

void Instance::declare_control(const EntrySpec& entry) {
  if (entry.broken) return scope_.hide(entry.name);
  auto read = read_control(entry, errors_);
  const int id =
      add_signal(entry.name, entry.at, FlatSignal::Kind::Control, static_cast<int>(flat_.controls.size()));
  if (read.unit_known) signal(id).declared = read.control.unit.dimension;
  signal(id).range = read.control.range;
  flat_.controls.push_back(std::move(read.control));
}

void Instance::declare_system() {
  Expression rate;
  rate.number = sample_rate().value;
  rate.dimension = parse_unit("Hz")->dimension;
  rate.bare = false;
  const int system_rate = add_expression("system.rate", {});
  signal(system_rate).expression = rate;
  const int delay = add_signal("system.delay", {}, FlatSignal::Kind::SystemDelay, -1);
  signal(delay).declared = parse_unit("s")->dimension;
  signal(delay).range = {0, 1};
}

void Instance::declare_inside() {
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

void Instance::declare_node(const NodeSpec& node) {
  const auto& table = resolving_.table;
  const auto* type = table.find(node.type);
  if (type != nullptr)
    return declare_outputs(node, std::shared_ptr<const NodeType>(std::shared_ptr<void>{}, type), true);
  std::vector<std::string> names;
  for (const auto* known : table.types) names.push_back(known->name);
  errors_.add(Errc::UnknownName, node.type_at, "there is no node type '" + node.type + "'",
              suggest(node.type, names, "`tactus nodes` lists them all"));
  scope_.hide(node.name);
}

void Instance::declare_network(const NetworkSpec& network) {
  auto type = resolving_.table.network ? resolving_.table.network(network)
                                       : Checked<std::shared_ptr<const NodeType>>{};
  if (!type || network.broken) {
    // An element without a type has been reported for that.
    auto errors = type ? std::vector<Error>{} : std::move(type.error());
    std::erase_if(errors, [&](const Error& error) {
      return std::any_of(network.elements.begin(), network.elements.end(), [&](const NodeSpec& element) {
        return element.type.empty() && element.type_at.text() == error.where;
      });
    });
    errors_.add(std::move(errors));
    return scope_.hide(network.name);
  }
  // Thousands of ports: asked for one by one they would take a time with their square.
  std::unordered_set<std::string_view> ports;
  ports.reserve((*type)->inputs.size());
  for (const auto& port : (*type)->inputs) ports.insert(port.name);
  EntrySpec entry{network.name, network.at, {}};
  for (const auto& element : network.elements)
    for (const auto& field : element.fields)
      if (auto port = element.name + "." + field.key; ports.contains(port))
        entry.fields.push_back({std::move(port), field.at, field.value});
  network_entries_.push_back(std::make_unique<EntrySpec>(std::move(entry)));
  const auto& outputs = (*type)->outputs;
  scope_.explain(network.name, "write an element of the network, such as '" + network.name + "." +
                                   (outputs.empty() ? "mass.position" : outputs.front().name) + "'");
  declare_outputs(*network_entries_.back(), *type, false);
}

void Instance::declare_outputs(const EntrySpec& entry, std::shared_ptr<const NodeType> type, bool bare_name) {
  const int index = static_cast<int>(flat_.nodes.size());
  FlatNode node;
  node.path = prefix_ + entry.name;
  node.at = entry.at;
  node.type = type;
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

void Instance::declare_part(const NodeSpec& node) {
  const auto part = spec_.parts.find(node.use);
  if (part == spec_.parts.end()) return scope_.hide(node.name);  // its file cannot be read
  if (too_large(node)) return scope_.hide(node.name);
  FieldReader fields{node.fields, part_fields(), errors_, FieldReader::kKeysChecked,
                     "part '" + node.name + "'"};
  const int voices = static_cast<int>(fields.number("voices").value_or(voices_));
  const auto rate = read_part_rate(node, *part->second, sample_rate(), errors_);
  auto instance = std::make_unique<Instance>(*part->second, resolving_, prefix_ + node.name + ".", voices,
                                             divisor_, rate);
  instance->declare_as_part();
  const int first_output = static_cast<int>(flat_.signals.size());
  declare_part_outputs(node, *part->second, *instance);
  pending_parts_.push_back({&node, std::move(instance), first_output});
}

bool Instance::too_large(const NodeSpec& node) {
  if (flat_.signals.size() < resolving_.most_signals) return false;
  if (!std::exchange(flat_.too_large, true))
    errors_.add(Errc::OutOfRange, node.type_at,
                "the parts contain more than " + std::to_string(resolving_.most_signals) + " signals",
                "use fewer nested parts");
  return true;
}

void Instance::declare_part_outputs(const NodeSpec& node, const GraphSpec& part, const Instance& instance) {
  using How = RateConversion::How;
  for (const auto& output : part.outputs) {
    const int id = add_expression(node.name + "." + output.name, node.at);
    if (instance.divisor_ != divisor_)
      signal(id).conversion = {instance.divisor_, instance.rate_.line ? How::Smooth : How::Last};
  }
  if (part.outputs.size() == 1)
    scope_.add(node.name, static_cast<int>(flat_.signals.size()) - 1);
  else
    scope_.explain(node.name, "write one of its outputs, such as '" + node.name + "." +
                                  (part.outputs.empty() ? "output" : part.outputs.front().name) + "'");
  if (part.incomplete) scope_.tolerate(node.name);
}

/// What a part is given: it comes from the rate around the part into its own.
int Instance::declare_binding(const EntrySpec& entry) {
  using How = RateConversion::How;
  const int id = add_expression(entry.name, entry.at);
  bindings_[entry.name] = id;
  if (divisor_ != outer_divisor_)
    signal(id).conversion = {outer_divisor_, rate_.mean ? How::Smooth : How::Last};
  return id;
}

void Instance::declare_as_part() {
  for (const auto& input : spec_.inputs) {
    const int id = declare_binding(input);
    if (input.broken) continue;
    read_input(input, errors_);
    const auto unit = read_unit(input, errors_);
    if (unit && find(input.fields, "unit") != nullptr) signal(id).declared = unit->dimension;
  }
  for (const auto& control : spec_.controls) {
    const int id = declare_binding(control);
    if (control.broken) continue;
    const auto read = read_control(control, errors_);
    if (!read.unit_known) continue;
    signal(id).declared = read.control.unit.dimension;
    auto& start = signal(id).expression;
    start = {};
    start.number = read.control.value;
    start.dimension = read.control.unit.dimension;
    start.bare = false;
    start.at = control.at;
  }
  tested_delays(spec_, errors_);
  declare_inside();
}

FlatGraph resolve(const GraphSpec& spec, const NodeTable& table, Hertz sample_rate, ErrorList& errors,
                  const std::vector<std::string>& taps, std::size_t most_signals) {
  FlatGraph flat;
  flat.signals.emplace_back().kind = FlatSignal::Kind::Missing;
  Resolving resolving{table, sample_rate, flat, errors, most_signals};
  Instance top{spec, resolving, "", 1};
  top.declare_top();
  top.connect_top(taps);
  return flat;
}

}  // namespace tactus
