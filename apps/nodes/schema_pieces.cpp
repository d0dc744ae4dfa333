#include "apps/nodes/schema_pieces.h"

#include <cmath>
#include <utility>

#include "engine/graph/file/quantity.h"

namespace tactus::schema {
namespace {

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
  if (fallback) text += "; " + short_number(*fallback) + " if left out";
  return text;
}

Json text(const std::string& description) {
  return {{"description", description}, {"type", "string"}, {"minLength", 1}};
}

Json whole_number(const std::string& description, double low, double high) {
  return joined({{"description", description}, {"type", "integer"}}, bounds(low, high));
}

Json choice(const std::string& description, const std::vector<std::string>& words) {
  return {{"description", description}, {"enum", words}};
}

Json list(const std::string& description, Json items, int least = 1, int most = 0) {
  Json json{
      {"description", description}, {"type", "array"}, {"items", std::move(items)}, {"minItems", least}};
  if (most > 0) json["maxItems"] = most;
  return json;
}

Json range(const std::string& description) { return list(description, quantity(""), 2, 2); }

Json object(const std::string& description, Json properties, const std::vector<std::string>& required) {
  Json json{{"description", description}, {"type", "object"}, {"properties", std::move(properties)}};
  if (!required.empty()) json["required"] = required;
  json["additionalProperties"] = false;
  return json;
}

Json channels(const std::string& description) {
  const auto one = whole_number("", 1, 1024);
  return {{"description", description}, {"anyOf", {one, list("", one), {{"const", "none"}}}}};
}

Json of_field(const FieldType& field) {
  using Kind = FieldType::Kind;
  const auto doc = field.doc + (field.fallback.empty() ? "" : "; " + field.fallback + " if left out");
  switch (field.kind) {
    case Kind::Text:
      break;
    case Kind::Prose:
      return {{"description", doc}, {"type", "string"}};
    case Kind::Quantity:
    case Kind::Any:
      return quantity(doc, field.low, field.high);
    case Kind::Signal:
      return signal(doc);
    case Kind::Whole:
      return whole_number(doc, field.low, field.high);
    case Kind::Flag:
      return {{"description", doc}, {"type", "boolean"}};
    case Kind::Choice:
      return choice(doc, field.choices);
    case Kind::Range:
      return range(doc);
    case Kind::Points:
      return list(doc, range(""));
    case Kind::Channels:
      return channels(doc);
    case Kind::Format:
      return {{"description", doc}, {"const", 1}};
    case Kind::Section:
      return schema::object(*field.inside);
    case Kind::Entries:
      return entries(doc, schema::object(*field.inside));
    case Kind::Settings:
      return entries(doc, quantity(""));
    case Kind::Reference:
      return entries(doc, reference(field.unit));
  }
  return text(doc);
}

Json of_setting(const Setting& setting) {
  const auto constant = quantity("");
  switch (setting.kind) {
    case Setting::Kind::Choice:
      return choice(setting.doc, setting.choices);
    case Setting::Kind::Integer:
      return whole_number(setting.doc, setting.low, setting.high);
    case Setting::Kind::Quantity:
      return quantity(described(setting.doc, setting.choices.empty() ? "" : setting.choices[0], {}),
                      setting.low, setting.high);
    case Setting::Kind::Flag:
      return {{"description", setting.doc}, {"type", "boolean"}};
    case Setting::Kind::Points:
      return list(setting.doc, list("", constant, 2, 2));
    case Setting::Kind::Numbers:
      return list(setting.doc, constant);
    case Setting::Kind::Names:
      return list(setting.doc, text(""));
    case Setting::Kind::Text:
    case Setting::Kind::File:
      break;
  }
  return text(setting.doc);
}

Json of_type(const std::string& name) { return {{"const", name}}; }

/// The keys that name other elements.
void add_ends(const ElementType& type, Json& properties, std::vector<std::string>& required) {
  using Ends = ElementType::Ends;
  if (type.ends == Ends::Between) {
    properties["between"] = list("two points, the lower one first", text(""), 2, 2);
    required.push_back("between");
  }
  if (type.ends == Ends::On || type.ends == Ends::Against) {
    properties["on"] = text("the point that it acts on");
    required.push_back("on");
  }
  if (type.ends == Ends::Against) properties["against"] = text("the point that it pushes off; none: fixed");
}

}  // namespace

Json quantity(const std::string& description, double low, double high) {
  return joined({{"description", description}, {"type", {"number", "string"}}, {"minLength", 1}},
                bounds(low, high));
}

Json signal(const std::string& description, double low, double high) {
  auto json = quantity(description, low, high);
  json["type"] = {"number", "string", "array", "object"};
  json["items"] = joined({{"type", {"number", "string"}}, {"minLength", 1}}, bounds(low, high));
  json["minItems"] = 1;
  json["properties"] = {{"from", quantity("of the first lane")},
                        {"to", quantity("of the last lane")},
                        {"curve", choice("from lane to lane", {"linear", "exponential"})}};
  json["required"] = {"from", "to"};
  json["additionalProperties"] = false;
  return json;
}

Json object(const SectionType& section) {
  auto properties = Json::object();
  std::vector<std::string> required;
  for (const auto& field : section.fields) {
    properties[field.key] = of_field(field);
    if (field.required) required.push_back(field.key);
  }
  auto json = object(section.doc, std::move(properties), required);
  for (const auto& key : section.one_of) json["anyOf"].push_back({{"required", {key}}});
  if (section.together.size() == 2)
    json["dependencies"] = {{section.together[0], {section.together[1]}},
                            {section.together[1], {section.together[0]}}};
  return json;
}

Json entries(const std::string& description, Json entry) {
  return {{"description", description},
          {"type", "object"},
          {"propertyNames",
           {{"pattern", "^[a-z][a-z0-9_]*$"}, {"not", {{"enum", {"system", "min", "max", "abs"}}}}}},
          {"additionalProperties", std::move(entry)}};
}

Json reference(const std::string& definition) { return {{"$ref", "#/definitions/" + definition}}; }

Json node(const NodeType& type) {
  Json properties{{"type", of_type(type.name)}};
  std::vector<std::string> required = {"type"};
  for (const auto& port : type.inputs) {
    properties[port.name] = signal(described(port.doc, port.unit, port.fallback), port.low, port.high);
    if (!port.fallback) required.push_back(port.name);
  }
  for (const auto& setting : type.settings) {
    properties[setting.name] = of_setting(setting);
    if (setting.fallback.empty() && !setting.optional) required.push_back(setting.name);
  }
  properties["voices"] = whole_number("how many lanes", 1, 1024);
  properties["about"] = text("for people");
  return object(type.summary, std::move(properties), required);
}

Json element(const ElementType& type) {
  Json properties{{"type", of_type(type.name)}};
  std::vector<std::string> required = {"type"};
  add_ends(type, properties, required);
  for (const auto& setting : type.settings) {
    properties[setting.name] = of_setting(setting);
    if (setting.fallback.empty()) required.push_back(setting.name);
  }
  for (const auto& field : type.fields) {
    properties[field.name] = signal(described(field.doc, field.unit, field.fallback), field.low, field.high);
    if (!field.fallback && !field.optional) required.push_back(field.name);
  }
  return object(type.doc, std::move(properties), required);
}

Json hints(Json alternatives) {
  alternatives.push_back(true);
  return alternatives;
}

Json by_type(const std::string& prefix, const std::vector<std::string>& types) {
  auto conditions = Json::array();
  auto alternatives = Json::array();
  for (const auto& type : types) {
    conditions.push_back({{"if", {{"properties", {{"type", of_type(type)}}}, {"required", {"type"}}}},
                          {"then", reference(prefix + type)}});
    alternatives.push_back(reference(prefix + type));
  }
  return {{"type", "object"},
          {"properties", {{"type", {{"enum", types}}}}},
          {"required", {"type"}},
          {"allOf", std::move(conditions)},
          {"anyOf", hints(std::move(alternatives))}};
}

}  // namespace tactus::schema
