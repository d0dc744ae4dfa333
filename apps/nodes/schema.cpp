#include "apps/nodes/schema.h"

#include "apps/nodes/schema_pieces.h"
#include "engine/graph/file/read_graph.h"
#include "engine/nodes/networks/solver_names.h"
#include "engine/rig/profile.h"
#include "engine/rig/rig.h"
#include "engine/scene/file/scene_fields.h"

namespace tactus {
namespace {

using namespace schema;

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
  auto json = object(part_fields());
  json["additionalProperties"] = signal("");
  return json;
}

Json network() {
  std::vector<std::string> solvers;
  for (const auto solver : kSolvers) solvers.emplace_back(name_of(solver));
  const SectionType options{"",
                            {choice_field("solver", solvers, "what steps it", "passive"),
                             whole_field("oversample", 1, 64, "steps in a frame", "1")}};
  auto json = entries("masses on a line and what joins them", reference("element"));
  json["properties"] = object(options)["properties"];
  json["minProperties"] = 1;
  return json;
}

Json scene() {
  auto json = object(scene_fields());
  auto& keys = json["properties"];
  keys["parts"]["required"] = {"plant"};
  keys["converters"]["not"] = {{"required", {"bits", "off"}}, {"properties", {{"off", {{"const", true}}}}}};
  auto value = quantity("a control, or another part's controls: plant.gain = 2");
  value["type"] = {"number", "string", "object"};
  value["additionalProperties"] = quantity("");
  keys["compare"]["additionalProperties"] = std::move(value);
  return json;
}

}  // namespace

std::string file_schema(const NodeTable& table) {
  Json definitions{{"graph", object(graph_fields())},
                   {"scene", scene()},
                   {"profile", object(profile_fields())},
                   {"rig", object(rig_fields())},
                   {"node", any_node()},
                   {"part", part()},
                   {"network", network()}};
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
