#include <fmt/format.h>

#include "engine/graph/file/quantity.h"
#include "engine/rig/rig.h"

namespace tactus {
namespace {

const Dimension kVolt = parse_unit("V")->dimension;
const Dimension kSecond = parse_unit("s")->dimension;
const Dimension kHertz = parse_unit("Hz")->dimension;

bool reads_back(const std::string& text, double si) {
  const auto parsed = parse_quantity(text);
  return parsed && parsed->si == si;
}

/// Volts over the unit of a port; all digits in SI where the usual name reads back as something else.
std::string sensitivity_text(const QuantityValue& sensitivity) {
  if (sensitivity.bare || sensitivity.unit.dimension == kVolt) return exact_quantity(sensitivity);
  return in_quotes(fmt::format("{} {}", sensitivity.si, volts_per(sensitivity.unit.dimension)));
}

std::string channel_text(const RigPort& port) {
  if (port.channels.empty()) return "channel = \"none\"";
  if (port.channels.size() == 1) return fmt::format("channel = {}", port.channels.front());
  return fmt::format("channel = [{}]", fmt::join(port.channels, ", "));
}

std::string about_text(const RigPort& port) {
  return port.about.empty() ? "" : ", about = " + in_quotes(port.about);
}

std::string line(const RigInput& input) {
  auto text = input.name + " = { " + channel_text(input);
  if (input.volts) text += ", volts_per_full_scale = " + exact_quantity(*input.volts, kVolt);
  if (input.sensitivity) text += ", sensitivity = " + sensitivity_text(*input.sensitivity);
  return text + about_text(input) + " }\n";
}

std::string line(const RigOutput& output) {
  auto text = output.name + " = { " + channel_text(output);
  const auto& drive = output.drive;
  if (!drive.profile.empty()) text += ", profile = " + in_quotes(drive.profile);
  if (drive.volts) text += ", volts_per_full_scale = " + exact_quantity(*drive.volts, kVolt);
  if (drive.ceiling) text += fmt::format(", ceiling = {}", *drive.ceiling);
  return text + about_text(output) + " }\n";
}

std::string line(const Rig::Control& control) {
  return control.name + " = " + exact_quantity(control.value) + "\n";
}

std::string line(const RigMidi& midi) {
  std::string text = midi.control + " = { ";
  if (!midi.device.empty()) text += "device = " + in_quotes(midi.device) + ", ";
  if (midi.channel > 0) text += fmt::format("channel = {}, ", midi.channel);
  constexpr const char* kKeys[] = {"control = {}", "note = {}", "pitch_bend = true"};  // as Kind
  text += fmt::format(fmt::runtime(kKeys[static_cast<int>(midi.kind)]), midi.number);
  return text + (midi.fine ? ", fine = true" : "") + (midi.gate ? ", gate = true" : "") + " }\n";
}

template <class Items>
std::string section(const char* name, const Items& items) {
  if (items.empty()) return "";
  std::string text = fmt::format("\n[{}]\n", name);
  for (const auto& item : items) text += line(item);
  return text;
}

std::string device_section(const Rig::Device& device) {
  auto text = "\n[device]\noutput = " + in_quotes(device.output) + "\n";
  if (!device.input.empty()) text += "input = " + in_quotes(device.input) + "\n";
  if (device.rate) text += "rate = " + exact_quantity(device.rate->value, kHertz) + "\n";
  if (device.block) text += fmt::format("block = {}\n", *device.block);
  if (device.periods) text += fmt::format("periods = {}\n", *device.periods);
  return text;
}

std::string delay_section(const Rig& rig) {
  if (!rig.measured_delay && !rig.pad_delay) return "";
  std::string text = "\n[delay]\n";
  if (rig.measured_delay) text += "measured = " + exact_quantity(rig.measured_delay->value, kSecond) + "\n";
  if (rig.pad_delay) text += "pad = " + exact_quantity(rig.pad_delay->value, kSecond) + "\n";
  return text;
}

}  // namespace

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      out += {'\\', c};
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      out += fmt::format("\\u{:04X}", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out + '"';
}

std::string volts_per(const Dimension& sensitivity) {
  const auto name = "V/" + to_string(kVolt / sensitivity);
  const auto unit = parse_unit(name);
  return unit && unit->dimension == sensitivity ? name : to_string(sensitivity);
}

std::string exact_quantity(double si, const Dimension& dimension) {
  if (dimension.plain()) return fmt::format("{}", si);
  const auto readable = short_quantity(si, dimension);
  return in_quotes(reads_back(readable, si) ? readable : fmt::format("{} {}", si, to_string(dimension)));
}

std::string exact_quantity(const QuantityValue& value) {
  if (value.unit.decibel) {
    const double decibels = value.unit.from_si(value.si);
    for (const auto& text : {fmt::format("{:.10g} dB", decibels), fmt::format("{} dB", decibels)})
      if (reads_back(text, value.si)) return in_quotes(text);
  }
  return exact_quantity(value.si, value.unit.dimension);
}

std::string to_text(const Rig& rig) {
  std::string text = "format = 1\n";
  if (!rig.name.empty()) text += "name = " + in_quotes(rig.name) + "\n";
  if (!rig.about.empty()) text += "about = " + in_quotes(rig.about) + "\n";
  return text + device_section(rig.device) + section("inputs", rig.inputs) + section("outputs", rig.outputs) +
         section("actuators", rig.actuators) + section("controls", rig.controls) + section("midi", rig.midi) +
         delay_section(rig);
}

}  // namespace tactus
