#include "apps/nodes/schema_files.h"

namespace tactus::schema {
namespace {

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

}  // namespace

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

}  // namespace tactus::schema
