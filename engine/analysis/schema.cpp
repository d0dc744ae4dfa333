#include "engine/analysis/schema.h"

#include "engine/analysis/schema_pieces.h"
#include "engine/nodes/solver_words.h"
#include "engine/scene/accuracy.h"
#include "engine/scene/measure.h"
#include "engine/scene/playability_section.h"

namespace tactus {
namespace {

using namespace schema;

/// What graphs and scenes both begin with.
Json heading() {
  return {{"format", {{"description", "of the file"}, {"const", 1}}},
          {"name", {{"description", "for people"}, {"type", "string"}}},
          {"about", {{"description", "for people: what it does"}, {"type", "string"}}},
          {"source", {{"description", "for people: where it comes from"}, {"type", "string"}}}};
}

Json range(const std::string& description) { return list(description, quantity(""), 2, 2); }
Json unit() { return text("\"m/s\", \"N/m\", \"ms\", \"dB\", \"full scale\"; a plain number if left out"); }

// ---- graphs
// ---------------------------------------------------------------------------------------------------

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

/// A node is an expression, a part, or of a type.
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

// ---- scenes
// ---------------------------------------------------------------------------------------------------

Json gesture() {
  return object("a value over time",
                {{"points", list("[[time, value], …], times increase", range(""))},
                 {"curve", choice("linear if left out", {"linear", "step", "smooth"})},
                 {"about", text("for people")}},
                {"points"});
}

Json converters() {
  auto json = object("of the simulated sound card",
                     {{"bits", whole_number("24 if left out", 1, 32)}, {"off", {{"type", "boolean"}}}});
  json["not"] = {{"required", {"bits", "off"}}, {"properties", {{"off", {{"const", true}}}}}};
  return json;
}

Json expectation() {
  std::vector<std::string> measures;
  for (const auto& type : measure_types()) measures.push_back(type.name);
  auto json = object("what must hold when the scene was played",
                     {{"measure", choice("what is measured", measures)},
                      {"of", text("what it is measured of, as in \"instrument.hit\"")},
                      {"from", quantity("time; the beginning if left out", 0, 86400)},
                      {"to", quantity("time; the end if left out", 0, 86400)},
                      {"min", quantity("least value")},
                      {"max", quantity("greatest value")},
                      {"about", text("for people")}},
                     {"measure"});
  json["anyOf"] = {{{"required", {"min"}}}, {{"required", {"max"}}}};
  return json;
}

Json accuracy() {
  std::vector<std::string> measures;
  for (const auto& type : accuracy_types()) measures.push_back(type.name);
  return object("what must come out right whatever the solver",
                {{"measure", choice("what is compared", measures)},
                 {"of", text("a signal, as in \"plant.stick\"")},
                 {"from", quantity("time; the beginning if left out", 0, 86400)},
                 {"to", quantity("time; the end if left out", 0, 86400)},
                 {"exact", quantity("what theory says; compared with a reference if left out")},
                 {"scale", quantity("an error of 1; of the reference if left out")},
                 {"about", text("for people")}},
                {"measure", "of"});
}

Json playability() {
  return object("what playing well means, for tactus study playability",
                {{"kind", choice("what is played", playability_kinds())},
                 {"from", quantity("what is judged begins here; 1 s if left out", 0, 86400)},
                 {"to", quantity("and ends here; with the scene if left out", 0, 86400)},
                 {"hits", text("of a roll: a trigger; instrument.hit if left out")},
                 {"contact", text("the force of what strikes; plant.contact if left out")},
                 {"fewest", whole_number("strikes in its worst second; 10 if left out", 1, 100)},
                 {"sound", text("of a tone: what is heard; instrument.sound if left out")},
                 {"pitch", quantity("the note wanted, in Hz", 1, 20e3)},
                 {"begin", quantity("when the bow is on; 0 s if left out", 0, 86400)},
                 {"quiet", quantity("softer is silent; -60 dB if left out", 1e-9, 1)},
                 {"about", text("for people")}},
                {"kind"});
}

Json comparison() {
  auto value = quantity("a control, or another part's controls: plant.gain = 2");
  value["type"] = {"number", "string", "object"};
  value["additionalProperties"] = quantity("");
  return {{"description", "the scene once more with some controls elsewhere"},
          {"type", "object"},
          {"properties", {{"name", text("as in \"without the pulse\"")}}},
          {"required", {"name"}},
          {"additionalProperties", std::move(value)}};
}

Json drive() {
  auto json =
      object("what the drive guard has to protect; cautious limits without a profile",
             {{"profile", text("woofer, bass_shaker, tactor_lra, voice_coil, …, or a path")},
              {"volts_per_full_scale", quantity("what a sample of 1 puts on its terminals", 1e-3, 1000)},
              {"ceiling", quantity("less than the profile allows, in full scale", 1e-6, 1)},
              {"about", text("for people")}});
  json["dependencies"] = {{"profile", {"volts_per_full_scale"}}, {"volts_per_full_scale", {"profile"}}};
  return json;
}

Json port() {
  return object("where a motor moves the plant: the energy that it gives is added up",
                {{"force", text("output of a part, in N: \"plant.motor\"")},
                 {"position", text("output of a part, in m: \"plant.arm\"")},
                 {"active_up_to", quantity("energy that the instrument may give", 0, 1e6)},
                 {"about", text("for people")}},
                {"force", "position", "active_up_to"});
}

Json scene() {
  auto keys = heading();
  keys["rate"] = quantity("sample rate; 48 kHz if left out", 1e3, 768e3);
  keys["delay"] = quantity("system delay; none if left out", 0, 10);
  keys["duration"] = quantity("how long it lasts", 1e-3, 86400);
  keys["seed"] = whole_number("of everything random", 0, 9007199254740991.0);
  keys["parts"] = entries("graphs and how they are wired", reference("part"));
  keys["parts"]["required"] = {"plant"};
  keys["gestures"] = entries("how the player moves", gesture());
  keys["converters"] = converters();
  keys["drives"] = entries("what the instrument's outputs move", drive());
  keys["ports"] = entries("where energy goes between instrument and plant", port());
  keys["expect"] = entries("what must hold", expectation());
  keys["accuracy"] = entries("what a study of solvers compares", accuracy());
  keys["playability"] = playability();
  keys["compare"] = comparison();
  return object("a scene", std::move(keys), {"format", "duration", "parts"});
}

// ---- profiles of actuators
// ---------------------------------------------------------------------------------------------------

Json terminals() {
  return object("the terminals",
                {{"resistance", quantity("of the coil, cold", 0.01, 1e6)},
                 {"peak", quantity("the most volts", 1e-3, 1000)},
                 {"slew", quantity("the most volts a second; no limit if left out", 1e-3, 1e9)},
                 {"soft_start", quantity("time from silence to full", 0, 60)},
                 {"fade_out", quantity("time to silence", 0, 1)}},
                {"resistance", "peak", "soft_start", "fade_out"});
}

Json heat() {
  return object("what it stands in heat",
                {{"power", quantity("steady, leads to the limit in the end", 1e-3, 1e5)},
                 {"coil_time", quantity("time constant of the coil", 0.01, 1e5)},
                 {"body_time", quantity("time constant of the body around it", 0.01, 1e6)},
                 {"coil_share", quantity("of the rise that lies between coil and body", 0.01, 0.99)},
                 {"rise", quantity("kelvin above the room", 1, 500)}},
                {"power", "coil_time", "body_time", "coil_share", "rise"});
}

Json travel() {
  return object("how far its mass may go",
                {{"limit", quantity("to either side", 1e-6, 1)},
                 {"mass", quantity("that moves", 1e-6, 100)},
                 {"stiffness", quantity("of its suspension", 1e-3, 1e9)},
                 {"damping", quantity("without the coil", 0, 1e6)},
                 {"force_factor", quantity("Bl", 1e-3, 1e4)}},
                {"limit", "mass", "stiffness", "damping", "force_factor"});
}

Json direct() {
  return object("direct current",
                {{"level", quantity("may last for ever", 1e-6, 1000)},
                 {"time", quantity("that the mean may lie above it", 0, 3600)}},
                {"level", "time"});
}

Json profile() {
  auto keys = heading();
  keys["drive"] = terminals();
  keys["heat"] = heat();
  keys["travel"] = travel();
  keys["direct"] = direct();
  return object("what an actuator stands", std::move(keys), {"format", "drive"});
}

// ---- rigs
// ---------------------------------------------------------------------------------------------------

Json channel() {
  const auto one = whole_number("", 1, 1024);
  return {{"description", "of the card, from 1; one for each lane; \"none\" leaves the port out"},
          {"anyOf", {one, list("", one), {{"const", "none"}}}}};
}

Json sensor() {
  auto json = object("a sensor",
                     {{"channel", channel()},
                      {"volts_per_full_scale", quantity("at the connector", 1e-6, 1000)},
                      {"sensitivity", quantity("volts for one unit of the port, as in \"2 V/m\"")},
                      {"about", text("for people")}},
                     {"channel"});
  json["dependencies"] = {{"sensitivity", {"volts_per_full_scale"}},
                          {"volts_per_full_scale", {"sensitivity"}}};
  return json;
}

Json wired_drive() {
  auto json = drive();
  json["properties"]["channel"] = channel();
  json["required"] = {"channel"};
  return json;
}

Json midi() {
  return object("what moves a control",
                {{"device", text("a part of the port's name; any if left out")},
                 {"channel", whole_number("any if left out", 1, 16)},
                 {"control", whole_number("number of the controller", 0, 127)},
                 {"note", whole_number("its velocity moves the control", 0, 127)},
                 {"pitch_bend", {{"const", true}}},
                 {"fine", {{"description", "14 bits, with controller + 32"}, {"type", "boolean"}}},
                 {"gate", {{"description", "a note opens and closes"}, {"type", "boolean"}}}});
}

Json rig() {
  auto keys = heading();
  keys.erase("source");
  keys["device"] = object("as `tactus devices` shows it",
                          {{"output", text("id")},
                           {"input", text("id; that of the output if left out")},
                           {"rate", quantity("sample rate", 8e3, 192e3)},
                           {"block", whole_number("frames", 1, 8192)},
                           {"periods", whole_number("blocks in the driver's buffer", 1, 64)}},
                          {"output"});
  keys["inputs"] = entries("where the instrument's inputs come from", sensor());
  keys["outputs"] = entries("where the instrument's outputs go", wired_drive());
  keys["actuators"] = entries("on channels that sound must never reach", wired_drive());
  keys["controls"] = entries("where the knobs stand", quantity(""));
  keys["midi"] = entries("what moves the controls", midi());
  keys["delay"] = object("system delay", {{"measured", quantity("of the card", 0, 10)},
                                          {"pad", quantity("hold the whole at this", 0, 10)}});
  return object("the hardware that an instrument plays on", std::move(keys), {"format", "device"});
}

}  // namespace

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
