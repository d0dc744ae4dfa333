#include "apps/nodes/schema_files.h"
#include "engine/scene/file/playability_section.h"
#include "engine/scene/file/roles.h"
#include "engine/scene/measures/measure.h"

namespace tactus::schema {
namespace {

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
  auto json = object("what must hold when the scene was played",
                     {{"measure", choice("what is measured", value_names())},
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
  return object("what must come out right whatever the solver",
                {{"measure", choice("what is compared", error_names())},
                 {"of", text("a signal, as in \"plant.stick\"")},
                 {"from", quantity("time; the beginning if left out", 0, 86400)},
                 {"to", quantity("time; the end if left out", 0, 86400)},
                 {"exact", quantity("what theory says; compared with a reference if left out")},
                 {"scale", quantity("an error of 1; of the reference if left out")},
                 {"about", text("for people")}},
                {"measure", "of"});
}

Json playability() {
  return object(
      "what playing well means, for tactus study playability",
      {{"kind", choice("what is played", playability_kinds())},
       {"from", quantity("what is judged begins here; 1 s if left out", 0, 86400)},
       {"to", quantity("and ends here; with the scene if left out", 0, 86400)},
       {"hits", text("of a roll: a trigger; the role 'hit' if left out")},
       {"contact", text("the force of what strikes; the role 'contact' if left out")},
       {"fewest", whole_number("strikes in its worst second; 10 if left out", 1, 100)},
       {"sound", text("of a tone: the output for ears; the role 'monitor' if left out")},
       {"pitch", quantity("the note wanted, in Hz, or what a part gives out: wanted.pitch", 1, 20e3)},
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

Json port() {
  return object("where a motor moves the plant: the energy that it gives is added up",
                {{"force", text("output of a part, in N: \"plant.motor\"")},
                 {"position", text("output of a part, in m: \"plant.arm\"")},
                 {"active_up_to", quantity("energy that the instrument may give", 0, 1e6)},
                 {"about", text("for people")}},
                {"force", "position", "active_up_to"});
}

}  // namespace

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
  auto roles = Json::object();
  for (const auto& type : role_types()) roles[type.name] = text(type.doc);
  keys["roles"] = object("which signal is what to measures and reports", std::move(roles));
  keys["expect"] = entries("what must hold", expectation());
  keys["accuracy"] = entries("what a study of solvers compares", accuracy());
  keys["playability"] = playability();
  keys["compare"] = comparison();
  return object("a scene", std::move(keys), {"format", "duration", "parts"});
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

}  // namespace tactus::schema
