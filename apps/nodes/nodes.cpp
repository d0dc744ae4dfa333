#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/nodes/file_reference.h"
#include "apps/nodes/schema.h"
#include "engine/graph/file/error_list.h"
#include "engine/nodes/networks/network_elements.h"
#include "engine/nodes/reference.h"
#include "engine/nodes/table.h"

namespace tactus::app {
namespace {

struct NodesOptions {
  std::string name;
  bool json = false;
  bool markdown = false;
  bool schema = false;
};

using Json = nlohmann::ordered_json;

/// JSON has no infinity: a bound that is not there is left out.
void add_range(Json& json, double low, double high) {
  if (std::isfinite(low)) json["low"] = low;
  if (std::isfinite(high)) json["high"] = high;
}

Json entry_json(const InputPort& port) {
  Json json{{"name", port.name}, {"unit", port.unit}, {"doc", port.doc}, {"required", !port.fallback}};
  if (port.fallback) json["default"] = *port.fallback;
  add_range(json, port.low, port.high);
  json["constant"] = port.fixed;
  json["closes_loops"] = port.late;
  return json;
}

Json entry_json(const OutputPort& port) {
  Json json{{"name", port.name},
            {"unit", port.unit},
            {"doc", port.doc},
            {"kind", port.kind == OutputKind::Trigger ? "trigger" : "signal"}};
  add_range(json, port.range.low, port.range.high);
  return json;
}

Json entry_json(const Setting& setting) {
  using Kind = Setting::Kind;
  Json json{{"name", setting.name},
            {"kind", setting_kind_name(setting.kind)},
            {"doc", setting.doc},
            {"required", setting.fallback.empty() && !setting.optional}};
  if (setting.kind == Kind::Choice) json["choices"] = setting.choices;
  if (setting.kind != Kind::Choice && !setting.choices.empty()) json["units"] = setting.choices;
  if (!setting.fallback.empty()) json["default"] = setting.fallback;
  add_range(json, setting.low, setting.high);
  return json;
}

Json entry_json(const ElementField& field) {
  Json json{{"name", field.name},
            {"unit", field.unit},
            {"doc", field.doc},
            {"required", !field.fallback && !field.optional}};
  if (field.fallback) json["default"] = *field.fallback;
  add_range(json, field.low, field.high);
  json["constant"] = field.fixed;
  return json;
}

Json entry_json(const ElementQuantity& quantity) {
  Json json{{"name", quantity.name}, {"unit", quantity.unit}, {"doc", quantity.doc}};
  add_range(json, quantity.range.low, quantity.range.high);
  return json;
}

Json entry_json(const ElementType& element);

template <class Items>
Json json_list(const Items& items) {
  auto list = Json::array();
  for (const auto& item : items) list.push_back(entry_json(item));
  return list;
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

Json entry_json(const ElementType& element) {
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

int report_unknown(const NodeTable& table, const std::string& name) {
  std::vector<std::string> names = {"network"};
  for (const auto* type : table.types) names.push_back(type->name);
  const auto near = nearest_name(name, names);
  fmt::print(stderr, "there is no node type '{}'; {}\n", name,
             find_element(name) ? "it is an element of networks, see `tactus nodes network`"
             : near.empty()     ? "`tactus nodes` lists them all"
                                : "did you mean '" + near + "'?");
  return kUsage;
}

int run_json(const NodeTable& table, const std::string& name) {
  Json all;
  const bool network = name.empty() || name == "network";
  if (!network || name.empty()) {
    all["nodes"] = Json::array();
    for (const auto* type : table.types)
      if (name.empty() || type->name == name) all["nodes"].push_back(entry_json(*type));
  }
  if (network) all["network_elements"] = json_list(network_elements());
  fmt::print("{}\n", all.dump(2));
  return kDone;
}

int run_nodes(const NodesOptions& options) {
  const auto& table = standard_nodes();
  const auto* type = table.find(options.name);
  if (!options.name.empty() && options.name != "network" && type == nullptr)
    return report_unknown(table, options.name);
  if (options.json) return run_json(table, options.name);
  fmt::print("{}", options.schema         ? file_schema(table)
                   : options.markdown     ? reference_markdown(table) + file_reference()
                   : options.name.empty() ? reference_overview(table)
                   : type != nullptr      ? reference_text(*type)
                                          : network_reference());
  return kDone;
}

}  // namespace

void add_nodes(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("nodes", "What a graph file can be made of");
  auto options = std::make_shared<NodesOptions>();
  command->add_option("NAME", options->name, "one type in full; `network` for the elements of networks");
  command->add_flag("--json", options->json, "for machines");
  command->add_flag("--markdown", options->markdown, "the whole reference (docs/nodes.md is made with it)");
  command->add_flag("--schema", options->schema,
                    "JSON Schema of graph files, for editors (docs/tactus.schema.json)");
  command->footer(
      "Examples:\n  tactus nodes\n  tactus nodes onset\n  tactus nodes network\n  tactus nodes delay --json");
  command->callback([options, &exit_code] { exit_code = run_nodes(*options); });
}

}  // namespace tactus::app
