#include <fmt/format.h>

#include <cmath>

#include "apps/cli/console.h"
#include "apps/cli/json.h"
#include "apps/nodes/schema.h"
#include "engine/graph/file/error_list.h"
#include "engine/nodes/networks/network_elements.h"
#include "engine/nodes/reference.h"
#include "engine/nodes/table.h"
#include "engine/nodes/world/world_elements.h"

namespace tactus::app {
namespace {

struct NodesOptions {
  std::string name;
  bool json = false;
  bool markdown = false;
  bool schema = false;
};

/// JSON has no infinity: a bound that is not there is left out.
void add_range(Json& json, double low, double high) {
  if (std::isfinite(low)) json["low"] = low;
  if (std::isfinite(high)) json["high"] = high;
}

/// What ports and fields have in common.
Json number_json(const InputPort& port, bool required) {
  Json json{{"name", port.name}, {"unit", port.unit}, {"doc", port.doc}, {"required", required}};
  if (port.fallback) json["default"] = *port.fallback;
  add_range(json, port.low, port.high);
  json["constant"] = port.fixed;
  return json;
}

Json entry_json(const InputPort& port) {
  auto json = number_json(port, !port.fallback);
  json["closes_loops"] = port.late;
  return json;
}

Json entry_json(const ElementField& field) { return number_json(field, !field.fallback && !field.optional); }

Json entry_json(const OutputPort& port) {
  Json json{{"name", port.name},
            {"unit", port.unit},
            {"doc", port.doc},
            {"kind", port.kind == OutputKind::Trigger ? "trigger" : "signal"}};
  add_range(json, port.range.low, port.range.high);
  return json;
}

Json entry_json(const Setting& setting) {
  const bool choice = setting.kind == Setting::Kind::Choice;
  Json json{{"name", setting.name},
            {"kind", setting_kind_name(setting.kind)},
            {"doc", setting.doc},
            {"required", setting.required}};
  if (choice || !setting.choices.empty()) json[choice ? "choices" : "units"] = setting.choices;
  if (!setting.fallback.empty()) json["default"] = setting.fallback;
  add_range(json, setting.low, setting.high);
  return json;
}

Json entry_json(const ElementQuantity& quantity) {
  Json json{{"name", quantity.name}, {"unit", quantity.unit}, {"doc", quantity.doc}};
  add_range(json, quantity.range.low, quantity.range.high);
  return json;
}

Json entry_json(const WorldQuantity& quantity) {
  const bool trigger = quantity.reading == WorldReading::Trigger;
  return {{"name", quantity.name}, {"unit", trigger ? "trigger" : quantity.unit}, {"doc", quantity.doc}};
}

template <class Element>
Json element_json(const Element& element);
Json entry_json(const ElementType& element);
Json entry_json(const WorldElementType& element);

template <class Items>
Json json_list(const Items& items) {
  return list_of(items, [](const auto& item) { return entry_json(item); });
}

Json entry_json(const NodeType& type) {
  return {{"name", type.name},
          {"group", type.group},
          {"summary", type.summary},
          {"equation", type.equation},
          {"source", type.source},
          {"example", type.example},
          {"inputs", json_list(type.inputs)},
          {"outputs", json_list(type.outputs)},
          {"settings", json_list(type.settings)}};
}

template <class Element>
Json element_json(const Element& element) {
  static constexpr const char* kEnds[] = {"none", "on", "on, against", "between"};
  return {{"name", element.name},
          {"summary", element.doc},
          {"equation", element.equation},
          {"ends", kEnds[static_cast<int>(element.ends)]},
          {"example", element.example},
          {"settings", json_list(element.settings)},
          {"fields", json_list(element.fields)},
          {"outputs", json_list(element.quantities)}};
}

Json entry_json(const ElementType& element) { return element_json(element); }
Json entry_json(const WorldElementType& element) { return element_json(element); }

[[noreturn]] void exit_unknown(const NodeTable& table, const std::string& name) {
  std::vector<std::string> names = {"network", "world"};
  for (const auto* type : table.types) names.push_back(type->name);
  const auto other = table.other_name(name);
  exit_with({Errc::UnknownName, "", "there is no node type '" + name + "'",
             find_element(name)         ? "it is an element of networks, see `tactus nodes network`"
             : find_world_element(name) ? "it is an element of worlds, see `tactus nodes world`"
             : !other.empty()           ? other
                                        : suggest(name, names, "`tactus nodes` lists them all")});
}

std::string json_text(const NodeTable& table, const std::string& name) {
  Json all;
  if (name != "network" && name != "world") all["nodes"] = Json::array();
  for (const auto* type : table.types)
    if (name.empty() || type->name == name) all["nodes"].push_back(entry_json(*type));
  if (name.empty() || name == "network") all["network_elements"] = json_list(network_elements());
  if (name.empty() || name == "world") all["world_elements"] = json_list(world_elements());
  return all.dump(2) + "\n";
}

int run_nodes(const NodesOptions& options) {
  const auto& table = standard_nodes();
  const auto& name = options.name;
  const auto* type = table.find(name);
  if (!name.empty() && name != "network" && name != "world" && type == nullptr) exit_unknown(table, name);
  fmt::print("{}", options.json       ? json_text(table, name)
                   : options.schema   ? file_schema(table)
                   : options.markdown ? reference_markdown(table) + file_reference()
                   : name.empty()     ? reference_overview(table)
                   : type != nullptr  ? reference_text(*type)
                   : name == "world"  ? world_reference()
                                      : network_reference());
  return kDone;
}

}  // namespace

void add_nodes(CLI::App& app, int& exit_code) {
  auto [command, options] =
      add_command(app, "nodes", "Print the reference for node types and elements of networks and worlds",
                  exit_code, run_nodes);
  command.add_option("NAME", options.name,
                     "node type to describe in full, or `network` or `world` for the elements of those");
  command.add_flag("--json", options.json, "print the reference as JSON");
  command.add_flag("--markdown", options.markdown,
                   "print the whole reference as Markdown (the source of docs/nodes.md)");
  command.add_flag("--schema", options.schema,
                   "print the JSON Schema of graph files, for editors (docs/tactus.schema.json)");
  command.footer(
      "Examples:\n  tactus nodes\n  tactus nodes onset\n  tactus nodes network\n  tactus nodes delay --json");
}

}  // namespace tactus::app
