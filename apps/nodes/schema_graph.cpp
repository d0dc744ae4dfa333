#include "apps/nodes/schema_files.h"
#include "engine/nodes/networks/solver_names.h"

namespace tactus::schema {
namespace {

Json unit() { return text("\"m/s\", \"N/m\", \"ms\", \"dB\", \"full scale\"; a plain number if left out"); }

Json input() {
  return object("what comes in",
                {{"unit", unit()}, {"about", text("for people")}, {"lanes", whole_number("", 1, 1024)}});
}

Json control() {
  return object("what the player sets",
                {{"value", quantity("where it starts")},
                 {"range", range("lowest and highest value")},
                 {"unit", unit()},
                 {"smooth", quantity("time in which it goes to a new value; 10 ms if left out", 0)},
                 {"about", text("for people")}},
                {"value"});
}

Json output() {
  return object("what goes out",
                {{"from", signal("an expression")},
                 {"kind", choice("for a hand or for the ears; drive if left out", {"drive", "audio"})},
                 {"unit", unit()},
                 {"about", text("for people")}},
                {"from"});
}

std::vector<std::string> solver_names() {
  std::vector<std::string> names;
  for (const auto solver : kSolvers) names.emplace_back(name_of(solver));
  return names;
}

Json network() {
  auto json = entries("masses on a line and what joins them", reference("element"));
  json["properties"] = {
      {"solver", choice("passive if left out", solver_names())},
      {"oversample", whole_number("steps in a frame", 1, 64)},
  };
  json["minProperties"] = 1;
  return json;
}

}  // namespace

Json any_node() {
  const Json is_object{{"type", "object"}};
  const Json uses{{"type", "object"}, {"required", {"use"}}};
  return {{"if", is_object},
          {"then", {{"if", uses}, {"then", reference("part")}, {"else", reference("typed_node")}}},
          {"else", {{"type", {"number", "string", "array"}}, {"minLength", 1}, {"minItems", 1}}},
          {"anyOf", hints({reference("part"), reference("typed_node")})}};
}

Json part() {
  return {{"description", "a graph file as a node; its inputs and controls are wired by name"},
          {"type", "object"},
          {"properties",
           {{"use", text("path of the file, from this one")},
            {"voices", whole_number("how many lanes", 1, 1024)},
            {"rate", text("of its own: a fraction, \"1/16\", or \"3 kHz\"; that around it if left out")},
            {"take", choice("what a frame at that rate is given: last if left out", {"last", "mean"})},
            {"between", choice("what goes out between two of them: hold if left out", {"hold", "line"})},
            {"about", text("for people")}}},
          {"required", {"use"}},
          {"additionalProperties", signal("")}};
}

Json graph() {
  auto keys = heading();
  keys["inputs"] = entries("sensors, or what a part is given", input());
  keys["controls"] = entries("what the player sets", control());
  keys["nodes"] = entries("`tactus nodes` explains each type", reference("node"));
  keys["networks"] = entries("`tactus nodes network` explains the elements", network());
  keys["outputs"] = entries("drives and sound, or what a part gives", output());
  keys["delay"] =
      object("system delay", {{"tested", range("shortest and longest that the instrument was tried with")}});
  return object("an instrument, a plant or a part", std::move(keys), {"format"});
}

}  // namespace tactus::schema
