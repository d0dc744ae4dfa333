#include "tests/realtime/every_node.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/graph/file/quantity.h"
#include "engine/graph/plan/compile.h"

namespace tactus::realtime {
namespace {

const char* const kBegin = R"toml(format = 1
name = "every node"
[inputs]
x = {}
[controls]
amount = { value = 0.5, range = [0, 1] }
[outputs]
drive = { from = "2 * x" }
sound = { from = "0.1 * echo", kind = "audio" }
[networks.drum]
frame  = { type = "ground" }
shaker = { type = "motion", position = "1 mm * within" }
cone   = { type = "mass", mass = "35 g" }
stick  = { type = "mass", mass = "12 g", at = "1 mm" }
hold   = { type = "spring", between = ["frame", "cone"], stiffness = "1000 N/m", damping = "1.2 kg/s" }
loss   = { type = "damper", between = ["shaker", "cone"], damping = "0.1 kg/s" }
lens   = { type = "contact", between = ["cone", "stick"], stiffness = "5e6 N/m^1.5", loss = "0.15 s/m" }
coil   = { type = "coil", on = "cone", voltage = "1 V * within", force_factor = "6 T m", resistance = "6 ohm" }
fall   = { type = "force", on = "stick", force = "-1 N" }
hand   = { type = "hand", on = "stick", stiffness = "10 N/m", force = "-0.1 N * within" }
rub    = { type = "friction", between = ["shaker", "cone"], normal = "1 N * within", law = "rosin" }
pick   = { type = "pluck", between = ["shaker", "stick"], stiffness = "300 N/m", limit = "0.1 N" }
bridge = { type = "port", on = "cone", impedance = "1 N s/m", wave = "0.1 N * within" }
string = { type = "chain", masses = 20, mass = "1 g", stiffness = "1e5 N/m", damping = "0.1 N s/m" }
tied   = { type = "spring", between = ["string.20", "cone"], stiffness = "1e4 N/m", cubic = "1e9 N/m^3" }
[nodes]
within = "min(max(0.5 + 0.5 * amount * x, 0), 1)"
)toml";

/// Values that move a port, and stay where it is defined.
Interval useful_range(const InputPort& port) {
  Interval range{-1, 1};
  if (port.unit == "s") range = {0.0005, 0.02};
  if (port.unit == "Hz") range = {20, 8000};
  if (port.unit == "m") range = {-0.01, 0.01};
  return {std::clamp(range.low, port.low, port.high), std::clamp(range.high, port.low, port.high)};
}

/// Signals of any unit are plain here, and what follows their unit a second is a frequency.
std::string unit_of(const InputPort& port) {
  if (port.unit.ends_with("/s") && port.unit.front() == '=') return " Hz";
  return port.unit.empty() || port.unit == "any" || port.unit.front() == '=' ? "" : " " + port.unit;
}

/// What the numbers of a version are times those of the first; nodes take it wherever they are made from one.
using Scale = double;
constexpr Scale kFirst = 1.0, kEdited = 0.9;

/// The node reads itself where it may, if its output has the unit of the input.
std::string expression(const NodeType& type, const InputPort& port, const std::string& node, Scale scale) {
  const auto range = useful_range(port);
  const auto unit = unit_of(port);
  const auto low = short_number(range.low) + unit, span = short_number(range.high - range.low) + unit;
  if (port.fixed) return low + " + " + short_number(0.65 * scale) + " * " + span;
  const auto& out = type.outputs.front().unit;
  const bool reads_itself = port.late && unit.empty() && (out.empty() || out.front() == '=');
  const auto loop = reads_itself ? " + 0.1 * " + node : "";
  return low + " + " + short_number(scale) + " * " + span + " * within" + loop;
}

/// Only of settings that have no default.
std::string value(const Setting& setting, const std::string& sound_file) {
  switch (setting.kind) {
    case Setting::Kind::Choice:
      return "\"" + setting.choices.front() + "\"";
    case Setting::Kind::Integer:
    case Setting::Kind::Quantity:
      return short_number(std::max(setting.low, 1.0));
    case Setting::Kind::Flag:
      return "true";
    case Setting::Kind::Points:
      return "[[0, 1], [1, 2]]";
    case Setting::Kind::Numbers:
      return "[0.25, 0.5, 0.25]";
    case Setting::Kind::Names:
      return "[\"within\"]";
    default:
      break;
  }
  return "\"" + sound_file + "\"";
}

std::string line(const NodeType& type, const std::string& name, const std::string& sound_file, Scale scale) {
  auto text = name + " = { type = \"" + type.name + "\"";
  for (const auto& port : type.inputs)
    text += ", " + port.name + " = \"" + expression(type, port, name, scale) + "\"";
  for (const auto& setting : type.settings)
    if (setting.required) text += ", " + setting.name + " = " + value(setting, sound_file);
  return text;
}

}  // namespace

Checked<std::unique_ptr<Plan>> every_node(const NodeTable& table, const std::string& folder,
                                          const std::string& sound_file, bool edited) {
  const Scale scale = edited ? kEdited : kFirst;
  std::string text = kBegin;
  if (edited) text.replace(text.find("12 g"), 4, "10 g");
  text +=
      "echo = " + std::string{edited ? R"({ type = "delay", in = "x", time = "1 ms" })" : R"("x")"} + "\n";
  CompileOptions options;
  options.taps = {"drum.stick", "drum.hand", "drum.coil"};
  for (const auto* type : table.types) {
    options.taps.push_back("the_" + type->name);
    text += line(*type, options.taps.back(), sound_file, scale) + " }\n";
    options.taps.push_back("eight_" + type->name);
    text += line(*type, options.taps.back(), sound_file, scale) + ", voices = 8 }\n";
  }
  return compile(parse_graph_leniently(text, folder + "/every_node.toml"), table, options);
}

}  // namespace tactus::realtime
