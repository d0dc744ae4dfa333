#include "tests/conformance/node_cases.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

namespace tactus::test {
namespace {

/// A short mono WAV file, 16 bits at 32 kHz: a rate that is not the engine's.
std::string sound_file() {
  static const std::string path = [] {
    // Tests run side by side as programs of their own: each has a file of its own.
    const auto name = "tactus_conformance_" + std::to_string(std::random_device{}()) + ".wav";
    const auto file = (std::filesystem::temp_directory_path() / name).string();
    std::ofstream out(file, std::ios::binary);
    const auto put = [&](std::uint32_t value, int bytes) {
      for (int i = 0; i < bytes; ++i) out.put(static_cast<char>((value >> (8 * i)) & 0xff));
    };
    out << "RIFF", put(36 + 600, 4), out << "WAVEfmt ", put(16, 4), put(1, 2), put(1, 2), put(32000, 4),
        put(64000, 4);
    put(2, 2), put(16, 2), out << "data", put(600, 4);
    for (std::uint32_t n = 0; n < 300; ++n) put((n * 7919) % 65536, 2);
    return file;
  }();
  return path;
}

/// Settings that no example line can show in full, by "type.setting".
std::map<std::string, std::string> example_settings() {
  return {{"sample.file", sound_file()},
          {"curve.points", "[[\"0 s\", 0], [\"10 ms\", 1]]"},
          {"map.points", "[[-1, 0.1], [0, 0.5], [1, 1]]"},
          {"proxy.heights", "[0, 0.002, -0.001, 0.001]"},
          {"terrain.points", "[[-0.01, 0], [-0.003, 0.002], [0.001, -0.001], [0.01, 0]]"}};
}

}  // namespace

std::optional<std::string> from_example(const std::string& line, const std::string& name) {
  auto at = line.find(" " + name + " = ");
  if (at == std::string::npos) return std::nullopt;
  at += name.size() + 4;
  if (line[at] == '"') return line.substr(at + 1, line.find('"', at + 1) - at - 1);
  if (line[at] != '[') return line.substr(at, line.find_first_of(", }", at) - at);
  int depth = 0;
  for (auto end = at; end < line.size(); ++end) {
    depth += line[end] == '[' ? 1 : line[end] == ']' ? -1 : 0;
    if (depth == 0) return line.substr(at, end - at + 1);
  }
  return std::nullopt;
}

namespace {

std::optional<std::string> example_of(const NodeType& type, const Setting& setting) {
  const auto table = example_settings();
  const auto found = table.find(type.name + "." + setting.name);
  return found != table.end() ? std::optional{found->second} : from_example(type.example, setting.name);
}

/// A box of everyday values by unit: large enough to move the node, small enough not to leave its useful
/// range.
Interval box(const std::string& unit) {
  static const std::pair<const char*, Interval> kBoxes[] = {
      {"s", {0.0005, 0.02}}, {"Hz", {20, 8000}}, {"m", {-0.01, 0.01}}, {"N/m", {0, 1000}}};
  const auto parsed = parse_unit(unit);
  for (const auto& [name, range] : kBoxes)
    if (parsed && parsed->dimension == parse_unit(name)->dimension) return range;
  return {-1, 1};
}

/// What a port gets in one case. The kinds turn with the seed, so that over some seeds each port sees each
/// kind.
InputValue drawn(const InputPort& port, int frames, unsigned seed, unsigned place) {
  const auto range = typical_range(port);
  const double low = range.low, span = range.high - range.low;
  if (port.fixed) return resting_value(port);
  const auto random = noise(frames, 1000 * seed + place);
  Samples samples(static_cast<std::size_t>(frames));
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const double along = static_cast<double>(n) / frames;
    switch ((seed + place) % 5) {
      case 0:
        return resting_value(port);
      case 1:
        samples[n] = low + span * (0.5 + 0.5 * random[n]);
        break;
      case 2:
        samples[n] = low + span * (seed % 2 == 0 ? along : 1 - along);
        break;
      case 3:
        samples[n] = std::clamp(n % 97 == 31 || n % 211 == 5 ? 1.0 : 0.0, low, range.high);
        break;
      default:
        samples[n] = low + span * (0.5 + 0.5 * random[n / 123]);
        break;
    }
  }
  return samples;
}

enum class Extreme { Zero, Square, Top, Bottom };

InputValue extreme(const InputPort& port, int frames, Extreme kind) {
  if (port.fixed) return resting_value(port);
  const bool bounded = std::isfinite(port.low) || std::isfinite(port.high);
  if (kind == Extreme::Zero) return Samples(static_cast<std::size_t>(frames), 0.0);
  if (bounded && kind != Extreme::Square)
    return Samples(static_cast<std::size_t>(frames), kind == Extreme::Top ? 1e30 : -1e30);
  Samples square(static_cast<std::size_t>(frames));
  for (std::size_t n = 0; n < square.size(); ++n) square[n] = n / 41 % 2 == 0 ? 1 : -1;
  return square;
}

}  // namespace

Interval typical_range(const InputPort& port) {
  auto range = box(port.unit);
  range = {std::max(range.low, port.low), std::min(range.high, port.high)};
  if (range.low <= range.high) return range;
  // The declared range lies outside the box: its finite end, and a little of what is beyond it.
  if (std::isfinite(port.low)) return {port.low, std::min(port.high, port.low + std::abs(port.low))};
  return {port.high - std::abs(port.high), port.high};
}

double resting_value(const InputPort& port) {
  const auto range = typical_range(port);
  return port.fallback.value_or(range.low + 0.65 * (range.high - range.low));
}

std::map<std::string, Interval> typical_ranges(const NodeType& type) {
  std::map<std::string, Interval> ranges;
  for (const auto& port : type.inputs) ranges[port.name] = typical_range(port);
  return ranges;
}

std::map<std::string, std::map<std::string, std::string>> setting_variants(const NodeType& type) {
  std::map<std::string, std::string> usual;
  const auto table = example_settings();
  for (const auto& setting : type.settings)
    if (setting.required || table.count(type.name + "." + setting.name) > 0)
      if (const auto example = example_of(type, setting)) usual[setting.name] = *example;
  std::map<std::string, std::map<std::string, std::string>> variants = {{"", usual}};
  for (const auto& setting : type.settings) {
    if (setting.name == kMotionSetting) continue;
    std::vector<std::string> words;
    if (setting.kind == Setting::Kind::Choice) words = setting.choices;
    if (setting.kind == Setting::Kind::Flag) words = {"true", "false"};
    for (const auto& word : words) {
      auto& variant = variants[setting.name + "=" + word] = usual;
      variant[setting.name] = word;
    }
  }
  return variants;
}

std::string missing_example(const NodeType& type) {
  for (const auto& setting : type.settings)
    if (setting.required && !example_of(type, setting))
      return "add an example setting for " + type.name + "." + setting.name +
             ": in the example line of the type, or in example_settings() of node_cases_test.cpp";
  return {};
}

std::string as_written(const Setting& setting, const std::string& value) {
  if (setting.kind == Setting::Kind::File)
    return "\"" + std::filesystem::path{value}.filename().string() + "\"";
  const bool text = setting.kind == Setting::Kind::Choice || setting.kind == Setting::Kind::Text ||
                    setting.kind == Setting::Kind::Unit;
  return text ? "\"" + value + "\"" : value;
}

std::string plain_signal(const std::string& name, std::string unit) {
  if (!unit.empty() && unit[0] == '=') {
    const auto factor = unit.find_first_of(" /");
    unit = factor == std::string::npos ? "" : "1" + unit.substr(factor);
  }
  if (unit.empty() || unit == "any") return name;
  return "(" + name + " / 1 " + (unit[0] == '1' ? "Hz" : unit) + ")";
}

NodeRunner NodeCase::runner() const { return {*type, inputs, settings, 48_kHz, typical_ranges(*type)}; }

NodeSetup NodeCase::setup() const {
  NodeSetup setup{.sample_rate = 48_kHz, .type = type, .inputs = {}, .settings = {}};
  for (const auto& port : type->inputs) {
    const auto* constant = std::get_if<double>(&inputs.at(port.name));
    setup.inputs.push_back({typical_range(port), constant ? std::optional{*constant} : std::nullopt, true});
    // A resting value need not lie in the box.
    if (constant) setup.inputs.back().range = Interval::exactly(*constant);
  }
  for (const auto& setting : type->settings) {
    const auto found = settings.find(setting.name);
    const auto& text = found != settings.end() ? found->second : setting.fallback;
    setup.settings.push_back(text.empty() ? SettingValue{} : setting_value(setting, text));
  }
  return setup;
}

std::vector<NodeCase> ordinary_cases(const NodeType& type, int frames, unsigned seeds) {
  std::vector<NodeCase> cases;
  for (const auto& [name, settings] : setting_variants(type))
    for (unsigned seed = 1; seed <= seeds; ++seed) {
      NodeCase one{&type, type.name + " " + name + " seed " + std::to_string(seed), settings, {}};
      for (unsigned i = 0; i < type.inputs.size(); ++i)
        one.inputs[type.inputs[i].name] = drawn(type.inputs[i], frames, seed, i);
      cases.push_back(std::move(one));
    }
  return cases;
}

std::vector<NodeCase> extreme_cases(const NodeType& type, int frames) {
  static const std::pair<const char*, Extreme> kKinds[] = {{"zero", Extreme::Zero},
                                                           {"square", Extreme::Square},
                                                           {"top", Extreme::Top},
                                                           {"bottom", Extreme::Bottom}};
  std::vector<NodeCase> cases;
  for (const auto& [name, settings] : setting_variants(type))
    for (const auto& [word, kind] : kKinds) {
      NodeCase one{&type, type.name + " " + name + " " + word, settings, {}};
      for (const auto& port : type.inputs) one.inputs[port.name] = extreme(port, frames, kind);
      cases.push_back(std::move(one));
    }
  return cases;
}

}  // namespace tactus::test
