#include "tests/conformance/extremes/subject.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/core/index.h"
#include "engine/nodes/networks/network_elements.h"
#include "tests/conformance/node_cases.h"

namespace tactus::test {
namespace {

std::string place_of(std::size_t slot) { return "@" + std::to_string(slot) + "@"; }

void replace_all(std::string& text, const std::string& what, const std::string& by) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
}

/// Of a unit as declarations write it: "ms", "any", "=in", "=in/s"; `type` has the port that it follows.
Counted counted_in(const std::string& unit, const NodeType* type = nullptr) {
  if (unit == "any") return {{}, 1};
  if (!unit.starts_with('=')) return {parse_unit(unit).value_or(Unit{}).dimension};
  const auto factor = unit.find_first_of(" /");
  const int followed = type != nullptr ? type->input_index(unit.substr(1, factor - 1)) : -1;
  Counted counted = followed < 0 ? Counted{{}, 1} : counted_in(type->inputs[index(followed)].unit);
  if (factor != std::string::npos)
    counted.dimension = counted.dimension * parse_unit("1" + unit.substr(factor))->dimension;
  return counted;
}

Interval typical_or_declared(const InputPort& port, double value) {
  const auto range = typical_range(port);
  return range.contains(value) ? range : Interval::exactly(value);
}

Slot port_slot(const InputPort& port, const NodeType& type) {
  Slot slot{.name = port.name, .counted = counted_in(port.unit, &type), .declared = {port.low, port.high}};
  slot.value = resting_value(port);
  slot.usual = typical_or_declared(port, slot.value);
  slot.moves = !port.fallback && !port.fixed && (slot.counted.level != 0 || slot.counted.plain());
  slot.fixed = port.fixed;
  slot.key = port.name;
  // A default that counts in a unit is written, so that it follows a change of units.
  slot.written = !port.fallback || (slot.value != 0 && !slot.counted.plain());
  return slot;
}

Interval declared(const Setting& setting) {
  if (setting.kind == Setting::Kind::Integer || setting.kind == Setting::Kind::Quantity)
    return {setting.low, setting.high};
  return {};
}

/// Puts a slot in the place of every number of a setting as it stands in a file.
std::string with_places(const Setting& setting, const std::string& text, std::vector<Slot>& slots) {
  std::string with;
  const bool points = setting.kind == Setting::Kind::Points;
  int count = 0;
  for (std::size_t at = 0; at < text.size();) {
    const bool quoted = text[at] == '"';
    const auto end =
        quoted ? text.find('"', at + 1) + 1 : std::min(text.find_first_of("[], ", at), text.size());
    const auto token = quoted ? text.substr(at + 1, end - at - 2) : text.substr(at, end - at);
    const auto quantity = token.empty() ? std::nullopt : parse_quantity(token);
    if (!quantity) {
      with += text[at++];
      continue;
    }
    const auto axis = points ? index(count % 2) : 0;
    const auto unit = axis < setting.choices.size() ? setting.choices[axis] : std::string{};
    Slot slot{.name = setting.name, .counted = counted_in(unit), .declared = declared(setting)};
    if (setting.kind == Setting::Kind::Points || setting.kind == Setting::Kind::Numbers)
      slot.name += " " + std::to_string(count);
    slot.value = quantity->si;
    slot.fixed = true;
    slot.whole = setting.kind == Setting::Kind::Integer;
    with += place_of(slots.size());
    slots.push_back(slot);
    ++count;
    at = end;
  }
  return with;
}

bool holds_numbers(const Setting& setting) {
  using Kind = Setting::Kind;
  return setting.kind == Kind::Integer || setting.kind == Kind::Quantity || setting.kind == Kind::Points ||
         setting.kind == Kind::Numbers;
}

/// A text that is a time, as the `min` and `max` of a delay.
bool is_time(const Setting& setting) {
  return setting.kind == Setting::Kind::Text && setting.doc.find("time") != std::string::npos;
}

/// A number between the limits of a setting whose default is no number.
std::string usual_number(const Setting& setting) {
  if (!setting.fallback.empty() && parse_quantity(setting.fallback)) return setting.fallback;
  const double low = std::isfinite(setting.low) ? setting.low : 1;
  return std::to_string(static_cast<long long>(std::min(std::max(2.0, low), setting.high)));
}

void add_settings(ExtremeSubject& subject, Line& line, const std::vector<Setting>& settings) {
  for (const auto& setting : settings) {
    const auto given = subject.settings.find(setting.name);
    const bool is_given = given != subject.settings.end();
    if (is_given && holds_numbers(setting)) {
      line.start += ", " + setting.name + " = " + with_places(setting, given->second, subject.slots);
    } else if (is_given) {
      line.start += ", " + setting.name + " = " + as_written(setting, given->second);
    } else if (setting.kind == Setting::Kind::Integer || setting.kind == Setting::Kind::Quantity) {
      std::vector<Slot> one;
      with_places(setting, usual_number(setting), one);
      if (one.empty()) continue;
      one[0].key = setting.name;
      one[0].written = false;
      line.slots.push_back(static_cast<int>(subject.slots.size()));
      subject.slots.push_back(one[0]);
    } else if (is_time(setting)) {
      line.slots.push_back(static_cast<int>(subject.slots.size()));
      subject.slots.push_back({.name = setting.name,
                               .counted = counted_in("s"),
                               .declared = {0, kUnlimited},
                               .value = setting.name == "max" ? 0.020 : 0.0,
                               .fixed = true,
                               .key = setting.name,
                               .written = setting.name == "max",
                               .quoted_unit = "s"});
    }
  }
}

ExtremeSubject node_subject(const NodeType& type, const std::string& variant,
                            const std::map<std::string, std::string>& settings) {
  ExtremeSubject subject{.family = type.group, .type = type.name, .settings = settings};
  subject.name = type.name + (variant.empty() ? "" : " " + variant);
  Line line{"tested = { type = \"" + type.name + "\"", {}};
  for (const auto& port : type.inputs) {
    line.slots.push_back(static_cast<int>(subject.slots.size()));
    subject.slots.push_back(port_slot(port, type));
  }
  add_settings(subject, line, type.settings);
  for (const auto& setting : type.settings)
    if (setting.kind == Setting::Kind::File && settings.contains(setting.name))
      subject.file = std::filesystem::path{settings.at(setting.name)}.parent_path() / "extremes.toml";
  subject.head = "[nodes]\n";
  subject.lines.push_back(std::move(line));
  for (const auto& output : type.outputs)
    subject.shown.push_back(
        {output.name, plain_signal("tested." + output.name, output.unit), counted_in(output.unit, &type)});
  return subject;
}

/// What an element's number is where nothing else is said, by unit.
double usual_field(const ElementField& field) {
  static const std::pair<const char*, double> kValues[] = {
      {"kg", 0.02}, {"N/m", 500}, {"N s/m", 2}, {"m", 0.001}, {"m/s", 0.1}, {"N", 1},      {"V", 1},
      {"ohm", 6},   {"H", 0.001}, {"T m", 6},   {"Hz", 440},  {"s/m", 1},   {"N/m^3", 1e6}};
  if (field.fallback) return *field.fallback;
  if (field.unit == "N/m^exponent") return 1e4;
  const auto unit = parse_unit(field.unit);
  for (const auto& [name, value] : kValues)
    if (unit && unit->dimension == parse_unit(name)->dimension)
      return std::clamp(value, field.low, field.high);
  return std::clamp(0.5, field.low, field.high);
}

Slot field_slot(const ElementField& field) {
  // With the default exponent of a contact; with another one: `Slot::exponent`.
  const auto unit = field.unit == "N/m^exponent" ? "N/m^1.5" : field.unit;
  Slot slot{.name = field.name, .counted = counted_in(unit), .declared = {field.low, field.high}};
  slot.value = usual_field(field);
  const double size = slot.value != 0 ? std::abs(slot.value) : unit == "m" ? 0.001 : 1;
  slot.usual = {-size, size};
  slot.fixed = field.fixed;
  slot.moves = !field.fixed && !field.fallback;
  slot.key = field.name;
  slot.instead_of = field.instead_of;
  slot.written = !field.optional || (field.one_required && field.instead_of.empty());
  if (field.fallback && (slot.value == 0 || slot.counted.plain())) slot.written = false;
  return slot;
}

/// Where an element of this kind hangs on the mass "ball" and the ground "floor", or on their likes in space.
std::string ends_of(const ElementType& type) {
  using Ends = ElementType::Ends;
  if (type.in_space && type.ends == Ends::Between) return ", between = [\"hook\", \"bob\"]";
  if (type.ends == Ends::Between) return ", between = [\"floor\", \"ball\"]";
  return type.ends == Ends::None ? "" : ", on = \"ball\"";
}

void add_number(ExtremeSubject& subject, Line& line, const std::string& key, const std::string& unit,
                double value) {
  line.slots.push_back(static_cast<int>(subject.slots.size()));
  subject.slots.push_back(
      {.name = "ball " + key, .counted = counted_in(unit), .value = value, .fixed = true, .key = key});
}

ExtremeSubject element_subject(const ElementType& type, const std::string& solver) {
  ExtremeSubject subject{.family = "element", .type = type.name, .name = type.name + " by " + solver};
  Line ball{"ball = { type = \"mass\"", {}},
      hold{"hold = { type = \"spring\", between = [\"floor\", \"ball\"]", {}};
  Line tested{"it = { type = \"" + type.name + "\"" + ends_of(type), {}};
  for (const auto& setting : type.settings)
    if (setting.required || setting.fallback.empty()) subject.settings[setting.name] = usual_number(setting);
  for (const auto& field : type.fields) {
    tested.slots.push_back(static_cast<int>(subject.slots.size()));
    subject.slots.push_back(field_slot(field));
  }
  for (std::size_t i = 0; i < type.fields.size(); ++i)
    if (type.fields[i].unit == "N/m^exponent")
      subject.slots[i].exponent = static_cast<int>(find_named(type.fields, "exponent") - type.fields.data());
  // An optional field that another one replaces: given where one of the two must be.
  for (auto& slot : subject.slots)
    for (const auto& other : type.fields)
      if (other.one_required && other.instead_of == slot.key) slot.written = true;
  add_settings(subject, tested, type.settings);
  add_number(subject, ball, "mass", "kg", 0.02);
  add_number(subject, ball, "at", "m", 0.001);
  add_number(subject, ball, "velocity", "m/s", 0.05);
  add_number(subject, hold, "stiffness", "N/m", 500);
  add_number(subject, hold, "damping", "N s/m", 2);
  subject.assumes_speed = solver == "auto";
  subject.head = "[networks.tested]\nsolver = \"" + solver + "\"\nfloor = { type = \"ground\" }\n";
  subject.lines = {ball, hold, tested};
  if (type.in_space && type.ends == ElementType::Ends::Between) {
    Line bob{"bob = { type = \"particle\"", {}};
    add_number(subject, bob, "mass", "kg", 0.02);
    add_number(subject, bob, "x", "m", 0.1);
    subject.lines.push_back(bob);
    subject.head += "hook = { type = \"anchor\" }\n";
  }
  const std::string body = type.dimensions == 2 ? "it.1.1" : type.dimensions == 1 ? "it.1" : "it";
  const auto point = type.in_space ? body + ".y" : body;
  if (type.ends == ElementType::Ends::None && type.takes_force) {
    Line join{"join = { type = \"spring\", between = [\"" + point + "\", \"ball\"]", {}};
    add_number(subject, join, "stiffness", "N/m", 300);
    subject.lines.push_back(join);
  }
  const auto show = [&](const std::string& name, const std::string& unit) {
    subject.shown.push_back({name, plain_signal("tested." + name, unit), counted_in(unit)});
  };
  show("ball.position", "m");
  for (const auto& quantity : type.quantities) show("it." + quantity.name, quantity.unit);
  return subject;
}

}  // namespace

double Units::factor(const Counted& counted) const {
  const auto& d = counted.dimension;
  return std::pow(metre, d.metre) * std::pow(kilogram, d.kilogram) * std::pow(second, d.second) *
         std::pow(ampere, d.ampere) * std::pow(level, counted.level);
}

std::string ExtremeSubject::text(const std::vector<std::string>& numbers) const {
  std::string all = head;
  for (const auto& line : lines) {
    all += line.start;
    for (const int slot : line.slots)
      if (const auto& number = numbers[index(slot)]; !number.empty())
        all += ", " + slots[index(slot)].key + " = " + number;
    all += " }\n";
  }
  for (std::size_t slot = 0; slot < slots.size(); ++slot) replace_all(all, place_of(slot), numbers[slot]);
  all += "[outputs]\n";
  for (std::size_t i = 0; i < shown.size(); ++i)
    all += "y" + std::to_string(i) + " = { from = \"" + shown[i].expression + "\" }\n";
  return all;
}

std::vector<ExtremeSubject> node_subjects() {
  std::vector<ExtremeSubject> subjects;
  for (const auto* type : standard_nodes().types)
    for (const auto& [variant, settings] : setting_variants(*type))
      subjects.push_back(node_subject(*type, variant, settings));
  return subjects;
}

std::vector<ExtremeSubject> element_subjects() {
  std::vector<ExtremeSubject> subjects;
  for (const auto& type : network_elements())
    for (const char* solver : {"auto", "passive", "implicit", "exact"})
      subjects.push_back(element_subject(type, solver));
  return subjects;
}

}  // namespace tactus::test
