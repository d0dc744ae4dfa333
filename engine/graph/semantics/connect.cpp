#include <filesystem>
#include <set>
#include <unordered_map>

#include "engine/graph/file/read_graph.h"
#include "engine/graph/semantics/instance.h"
#include "engine/graph/semantics/scope.h"

namespace tactus {
namespace {

std::filesystem::path folder_of(const GraphSpec& spec) {
  return spec.file.file ? std::filesystem::path{*spec.file.file}.parent_path() : std::filesystem::path{};
}

}  // namespace

void Instance::connect_top(const std::vector<std::string>& taps) {
  connect_inside();
  for (const auto& output : spec_.outputs)
    if (!output.broken) connect_output(output);
  for (const auto& tap : taps) connect_tap(tap);
}

void Instance::connect_inside() {
  for (const auto& node : spec_.nodes) {
    if (!node.value) continue;
    auto expression = bind_signal(*node.value, scope_, errors_);
    if (const auto id = scope_.find(node.name, node.at); id && *id != FlatGraph::kMissing)
      signal(*id).expression = std::move(expression);
  }
  for (const auto& pending : pending_nodes_) connect_node(*pending.spec, flat_.nodes[pending.flat]);
  for (const auto& pending : pending_parts_) connect_part(pending);
}

void Instance::connect_node(const EntrySpec& entry, FlatNode& node) {
  const auto& type = *node.type;
  const auto owner = type.name + " '" + entry.name + "'";
  auto known = node_fields().keys();
  for (const auto& port : type.inputs) known.push_back(port.name);
  for (const auto& setting : type.settings) known.push_back(setting.name);
  errors_.unknown_keys(entry.fields, known, owner);
  FieldReader fields{entry.fields, node_fields(), errors_, FieldReader::kKeysChecked, owner};
  if (const auto voices = fields.number("voices")) node.voices = static_cast<int>(*voices);
  connect_ports(entry, node, owner);
  for (const auto& setting : type.settings) {
    node.settings.push_back(bind_setting(setting, entry.fields, folder_of(spec_), owner, entry.at, errors_));
    if (setting.kind == Setting::Kind::Names) connect_compensation(entry, setting.name, node);
  }
}

void Instance::connect_ports(const EntrySpec& entry, FlatNode& node, const std::string& owner) {
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

void Instance::connect_compensation(const EntrySpec& entry, const std::string& field, FlatNode& node) {
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
        errors_.add(Errc::BadArgument, value->at, "'" + name + "' cannot be compensated: it is not a filter",
                    "omit it; list only nodes that change the phase");
      node.compensate.push_back(known->second);
    } else if (scope_.find(name, value->at) != FlatGraph::kMissing) {
      errors_.add(Errc::UnknownName, value->at, "there is no node '" + name + "' to compensate",
                  "list nodes of this file that have a type");
    }
  }
}

void Instance::check_part_fields(const NodeSpec& node, const Instance& part) {
  const auto owner = "part '" + node.name + "'";
  auto known = part_keys(part.spec_);
  for (const auto& [name, id] : part.bindings_) known.push_back(name);
  if (!part.spec_.incomplete) errors_.unknown_keys(node.fields, known, owner);
  for (const auto& input : part.spec_.inputs) {
    if (find(node.fields, input.name) != nullptr) continue;
    const auto* about = find(input.fields, "about");
    errors_.add(Errc::Missing, node.at, owner + " lacks '" + input.name + "'",
                about != nullptr && about->text() != nullptr ? *about->text()
                                                             : "it is an input of " + *part.spec_.file.file);
  }
}

void Instance::connect_part(const PendingPart& pending) {
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
  part.connect_inside();
  int id = pending.first_output;
  for (const auto& output : part.spec_.outputs) {
    if (!output.broken) part.bind_output(output, signal(id).expression, signal(id).declared);
    ++id;
  }
}

void Instance::bind_output(const EntrySpec& entry, Expression& expression,
                           std::optional<Dimension>& declared) {
  FieldReader{entry.fields, output_fields(), errors_, "output '" + entry.name + "'"};
  const auto* from = find(entry.fields, "from");
  if (from == nullptr)
    errors_.add(Errc::Missing, entry.at, "output '" + entry.name + "' lacks 'from'",
                "give its source, as in from = \"node\"");
  expression = from != nullptr ? bind_signal(*from, scope_, errors_) : missing_signal(entry.at);
  const auto unit = read_unit(entry, errors_);
  if (unit && find(entry.fields, "unit") != nullptr) declared = unit->dimension;
}

void Instance::connect_output(const EntrySpec& entry) {
  FlatOutput output;
  output.name = entry.name;
  output.at = entry.at;
  bind_output(entry, output.expression, output.declared);
  // A drive is a plain number unless the file gives another unit; a wrong unit is unknown.
  if (find(entry.fields, "unit") == nullptr) output.declared = Dimension{};
  output.use = read_use(entry, errors_);
  flat_.outputs.push_back(std::move(output));
}

void Instance::connect_tap(const std::string& name) {
  FlatOutput output;
  output.name = name;
  output.use = OutputUse::Tap;
  const auto found = scope_.find(name, spec_.file);
  if (errors_.keep(found) == nullptr) return;
  output.expression.op = Expression::Op::Signal;
  output.expression.signal = *found;
  flat_.outputs.push_back(std::move(output));
}

}  // namespace tactus
