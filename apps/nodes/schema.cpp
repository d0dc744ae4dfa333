#include "apps/nodes/schema.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "apps/cli/json.h"
#include "engine/graph/file/read_graph.h"
#include "engine/graph/semantics/operators.h"
#include "engine/nodes/networks/network_elements.h"
#include "engine/nodes/networks/solver_names.h"
#include "engine/nodes/world/world_elements.h"
#include "engine/rig/profile.h"
#include "engine/rig/rig.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/scene/measures/measure.h"

namespace tactus {
namespace {

using app::Json;

/// JSON has no infinity: a bound that is not there is left out.
Json bounds(double low, double high) {
  auto json = Json::object();
  if (std::isfinite(low)) json["minimum"] = low;
  if (std::isfinite(high)) json["maximum"] = high;
  return json;
}

Json joined(Json json, const Json& more) {
  json.update(more);
  return json;
}

/// "corner [Hz]; 20 if left out"
std::string described(const std::string& doc, const std::string& unit, std::optional<double> fallback) {
  auto text = doc;
  if (unit.starts_with('='))
    text += " [unit as " + unit.substr(1) + "]";
  else if (!unit.empty() && unit != "any")
    text += " [" + unit + "]";
  if (fallback) text += "; default: " + short_number(*fallback);
  return text;
}

Json text(const std::string& description) {
  return {{"description", description}, {"type", "string"}, {"minLength", 1}};
}

Json whole_number(const std::string& description, double low, double high) {
  return joined({{"description", description}, {"type", "integer"}}, bounds(low, high));
}

Json choice(const std::string& description, const std::vector<std::string>& choices) {
  return {{"description", description}, {"enum", choices}};
}

Json list(const std::string& description, Json items, int least = 1, int most = 0) {
  Json json{
      {"description", description}, {"type", "array"}, {"items", std::move(items)}, {"minItems", least}};
  if (most > 0) json["maxItems"] = most;
  return json;
}

/// A number or a quantity ("15 ms"); the bounds hold for bare numbers, which count in SI.
Json quantity(const std::string& description, double low = -kUnlimited, double high = kUnlimited) {
  return joined({{"description", description}, {"type", {"number", "string"}}, {"minLength", 1}},
                bounds(low, high));
}

Json range(const std::string& description) { return list(description, quantity(""), 2, 2); }

Json channels(const std::string& description) {
  const auto one = whole_number("", 1, 1024);
  return {{"description", description}, {"anyOf", {one, list("", one), {{"const", "none"}}}}};
}

/// Where a signal belongs: a number, an expression, a list of lanes or a spread over lanes.
Json signal(const std::string& description, double low = -kUnlimited, double high = kUnlimited) {
  auto json = quantity(description, low, high);
  json["type"] = {"number", "string", "array", "object"};
  json["items"] = joined({{"type", {"number", "string"}}, {"minLength", 1}}, bounds(low, high));
  json["minItems"] = 1;
  json["properties"] = {{"from", quantity("value of the first lane")},
                        {"to", quantity("value of the last lane")},
                        {"curve", choice("spacing between lanes", {"linear", "exponential"})}};
  json["required"] = {"from", "to"};
  json["additionalProperties"] = false;
  return json;
}

/// The keys of an object; nothing else is allowed in it.
struct Keys {
  Json properties = Json::object();
  std::vector<std::string> required{};

  void add(const std::string& key, Json value, bool is_required = false) {
    properties[key] = std::move(value);
    if (is_required) required.push_back(key);
  }
  Json object(const std::string& description) const {
    Json json{{"description", description}, {"type", "object"}, {"properties", properties}};
    if (!required.empty()) json["required"] = required;
    json["additionalProperties"] = false;
    return json;
  }
};

/// Constants may name what expressions do not: outputs, expectations.
std::vector<std::string> reserved_everywhere() {
  std::vector<std::string> names;
  for (const auto& name : reserved_names())
    if (find_constant(name) == nullptr) names.emplace_back(name);
  return names;
}

/// An object of entries with free names, each like `entry`.
Json entries(const std::string& description, Json entry) {
  return {{"description", description},
          {"type", "object"},
          {"propertyNames", {{"pattern", "^[a-z][a-z0-9_]*$"}, {"not", {{"enum", reserved_everywhere()}}}}},
          {"additionalProperties", std::move(entry)}};
}

Json reference(const std::string& definition) { return {{"$ref", "#/definitions/" + definition}}; }

Json section_schema(const SectionType& section);

Json of_field(const FieldType& field) {
  using Kind = FieldType::Kind;
  const auto of = field.kind == Kind::Quantity ? field.unit() : "";
  const auto doc =
      described(field.doc, of, {}) + (field.fallback.empty() ? "" : "; default: " + field.fallback);
  switch (field.kind) {
    case Kind::Text:
    case Kind::File:
    case Kind::Unit:
      break;
    case Kind::Prose:
      return {{"description", doc}, {"type", "string"}};
    case Kind::Quantity:
    case Kind::Any:
      return quantity(doc, field.low, field.high);
    case Kind::Signal:
      return signal(doc);
    case Kind::Integer:
      return whole_number(doc, field.low, field.high);
    case Kind::Flag:
      return {{"description", doc}, {"type", "boolean"}};
    case Kind::Choice:
      return choice(doc, field.choices);
    case Kind::Range:
      return range(doc);
    case Kind::Points:
      return list(doc, range(""));
    case Kind::Numbers:
      return list(doc, quantity(""));
    case Kind::Names:
      return list(doc, text(""));
    case Kind::Channels:
      return channels(doc);
    case Kind::Format:
      return {{"description", doc}, {"const", 1}};
    case Kind::Section:
      return section_schema(*field.inside);
    case Kind::Entries:
      return entries(doc, section_schema(*field.inside));
    case Kind::Settings:
      return entries(doc, quantity(""));
    case Kind::Reference:
      return entries(doc, reference(field.unit()));
  }
  return text(doc);
}

Json section_schema(const SectionType& section) {
  Keys keys;
  for (const auto& field : section.fields) keys.add(field.name, of_field(field), field.required);
  auto json = keys.object(section.doc);
  for (const auto& key : section.one_of) json["anyOf"].push_back({{"required", {key}}});
  if (section.together.size() == 2)
    json["dependencies"] = {{section.together[0], {section.together[1]}},
                            {section.together[1], {section.together[0]}}};
  return json;
}

/// The keys that name other elements.
template <class Element>
void add_ends(const Element& type, Keys& keys) {
  using Ends = ElementType::Ends;
  if (type.ends == Ends::Between)
    keys.add("between", list("two points, the lower one first", text(""), 2, 2), true);
  if (type.ends == Ends::On || type.ends == Ends::Against)
    keys.add("on", text("point that the element acts on"), true);
  if (type.ends == Ends::Against)
    keys.add("against", text("point that receives the reaction force; default: fixed"));
}

Json node(const NodeType& type) {
  Keys keys;
  keys.add("type", {{"const", type.name}}, true);
  for (const auto& port : type.inputs)
    keys.add(port.name, signal(described(port.doc, port.unit, port.fallback), port.low, port.high),
             !port.fallback);
  for (const auto& setting : type.settings) keys.add(setting.name, of_field(setting), setting.required);
  keys.add("voices", whole_number("number of lanes", 1, 1024));
  keys.add("about", text("for people"));
  return keys.object(type.summary);
}

template <class Element>
Json element(const Element& type) {
  Keys keys;
  keys.add("type", {{"const", type.name}}, true);
  add_ends(type, keys);
  for (const auto& setting : type.settings) keys.add(setting.name, of_field(setting), setting.required);
  for (const auto& field : type.fields)
    keys.add(field.name, signal(described(field.doc, field.unit, field.fallback), field.low, field.high),
             !field.fallback && !field.optional);
  return keys.object(type.doc);
}

/// For `anyOf`: what an editor may complete from, which forbids nothing. Many editors complete from
/// alternatives only; but a validator that tries alternatives reports "none of them" where a condition
/// reports what is wrong.
Json hints(Json alternatives) {
  alternatives.push_back(true);
  return alternatives;
}

/// An object whose `type` decides what it is: one definition called `prefix` + type for each of `types`.
Json by_type(const std::string& prefix, const std::vector<std::string>& types) {
  auto conditions = Json::array();
  auto alternatives = Json::array();
  for (const auto& type : types) {
    conditions.push_back({{"if", {{"properties", {{"type", {{"const", type}}}}}, {"required", {"type"}}}},
                          {"then", reference(prefix + type)}});
    alternatives.push_back(reference(prefix + type));
  }
  return {{"type", "object"},
          {"properties", {{"type", {{"enum", types}}}}},
          {"required", {"type"}},
          {"allOf", std::move(conditions)},
          {"anyOf", hints(std::move(alternatives))}};
}

/// A node of a graph is an expression, a part, or of a type.
Json any_node() {
  const Json is_object{{"type", "object"}};
  const Json uses{{"type", "object"}, {"required", {"use"}}};
  return {{"if", is_object},
          {"then", {{"if", uses}, {"then", reference("part")}, {"else", reference("typed_node")}}},
          {"else", {{"type", {"number", "string", "array"}}, {"minLength", 1}, {"minItems", 1}}},
          {"anyOf", hints({reference("part"), reference("typed_node")})}};
}

Json part() {
  auto json = section_schema(part_fields());
  json["additionalProperties"] = signal("");
  return json;
}

Json network() {
  auto json = entries("masses on a line and the elements between them", reference("element"));
  json["properties"] = section_schema(network_options())["properties"];
  json["minProperties"] = 1;
  return json;
}

Json world() {
  auto json = entries("rigid bodies in space and what acts on them", reference("world_element"));
  json["properties"] = section_schema(world_options())["properties"];
  json["minProperties"] = 1;
  return json;
}

Json scene() {
  auto json = section_schema(scene_fields());
  auto& keys = json["properties"];
  keys["parts"]["minProperties"] = 1;
  keys["converters"]["not"] = {{"required", {"bits", "off"}}, {"properties", {{"off", {{"const", true}}}}}};
  auto value = quantity("a control, or another part's controls: plant.gain = 2");
  value["type"] = {"number", "string", "object"};
  value["additionalProperties"] = quantity("");
  keys["compare"]["additionalProperties"] = std::move(value);
  return json;
}

std::string range_of(const FieldType& field) {
  if (field.kind == FieldType::Kind::Choice) return fmt::format("`{}`", fmt::join(field.choices, "`, `"));
  const auto dimension = parse_unit(field.unit()).value_or(Unit{}).dimension;
  const auto number = [&](double si) { return std::isfinite(si) ? short_quantity(si, dimension) : "any"; };
  if (!std::isfinite(field.low) && !std::isfinite(field.high)) return "";
  return number(field.low) + " to " + number(field.high);
}

/// The keys of a section and, after it, those of the sections in it. `title` is its path: "scene",
/// "[expect]".
std::string table_of(const std::string& title, const SectionType& section) {
  auto text = fmt::format("\n### {}\n\n{}.\n\n| key | range | default | meaning |\n|---|---|---|---|\n",
                          title, section.doc);
  for (const auto& field : section.fields)
    text +=
        fmt::format("| `{}` | {} | {} | {} |\n", field.name, field.name == "measure" ? "" : range_of(field),
                    field.required ? "required" : field.fallback, field.doc);
  for (const auto& field : section.fields)
    if (field.inside != nullptr)
      text += table_of(field.kind == FieldType::Kind::Entries ? fmt::format("entries of [{}]", field.name)
                                                              : fmt::format("[{}]", field.name),
                       *field.inside);
  return text;
}

std::string unit_of(const Measure& type) {
  return type.unit == Measure::kUnitOfSubject ? "that of the signal" : type.unit;
}

std::string measure_tables() {
  static constexpr const char* kOf[] = {"the scene", "a signal", "events", "a port", "[playability]"};
  std::string text =
      "\n## Measures\n\nIn `[expect]`. Events are the triggers of a signal, or the strikes in a force: "
      "pulses above 5 N, at least 5 ms apart.\n\n| measure | of | unit | meaning |\n|---|---|---|---|\n";
  for (const auto& type : measures())
    if (type.value != nullptr)
      text +=
          fmt::format("| `{}` | {}{} | {} | {} |\n", type.name, kOf[static_cast<int>(type.subject)],
                      type.of.empty() ? "" : ", else the role `" + type.of + "`", unit_of(type), type.doc);
  text += "\nIn `[accuracy]`.\n\n| measure | unit | error |\n|---|---|---|\n";
  for (const auto& type : measures())
    if (type.error != nullptr)
      text += fmt::format("| `{}` | {} | {} |\n", type.name, unit_of(type), type.error_doc);
  return text;
}

}  // namespace

std::string file_reference() {
  return "\n## Keys of files\n" + table_of("Graph", graph_fields()) +
         table_of("Part in a graph", part_fields()) + table_of("Scene", scene_fields()) +
         table_of("Rig", rig_fields()) + table_of("Actuator profile", profile_fields()) + measure_tables();
}

std::string file_schema(const NodeTable& table) {
  Json definitions{{"graph", section_schema(graph_fields())},
                   {"scene", scene()},
                   {"profile", section_schema(profile_fields())},
                   {"rig", section_schema(rig_fields())},
                   {"node", any_node()},
                   {"part", part()},
                   {"network", network()},
                   {"world", world()}};
  std::vector<std::string> nodes, elements, bodies;
  for (const auto* type : table.types) {
    nodes.push_back(type->name);
    definitions["node_" + type->name] = node(*type);
  }
  for (const auto& type : network_elements()) {
    elements.push_back(type.name);
    definitions["element_" + type.name] = element(type);
  }
  for (const auto& type : world_elements()) {
    bodies.push_back(type.name);
    definitions["world_element_" + type.name] = element(type);
  }
  definitions["world_element"] = by_type("world_element_", bodies);
  definitions["typed_node"] = by_type("node_", nodes);
  definitions["element"] = by_type("element_", elements);
  const Json all{
      {"$schema", "http://json-schema.org/draft-07/schema#"},
      {"title", "Tactus graph files"},
      {"if", {{"required", {"parts"}}}},
      {"then", reference("scene")},
      {"else",
       {{"if", {{"required", {"drive"}}}},
        {"then", reference("profile")},
        {"else",
         {{"if", {{"required", {"device"}}}}, {"then", reference("rig")}, {"else", reference("graph")}}}}},
      {"anyOf", hints({reference("graph"), reference("scene"), reference("profile"), reference("rig")})},
      {"definitions", std::move(definitions)}};
  return all.dump(1) + "\n";
}

}  // namespace tactus
