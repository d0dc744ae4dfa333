#include "apps/nodes/schema.h"

#include "apps/nodes/schema_files.h"

namespace tactus {

using namespace schema;

std::string file_schema(const NodeTable& table) {
  Json definitions{{"graph", graph()}, {"scene", scene()},   {"profile", profile()},
                   {"rig", rig()},     {"node", any_node()}, {"part", part()}};
  std::vector<std::string> nodes, elements;
  for (const auto* type : table.types) {
    nodes.push_back(type->name);
    definitions["node_" + type->name] = node(*type);
  }
  for (const auto& type : network_elements()) {
    elements.push_back(type.name);
    definitions["element_" + type.name] = element(type);
  }
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
