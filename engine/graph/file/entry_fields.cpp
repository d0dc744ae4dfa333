#include "engine/graph/file/entry_fields.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <unordered_set>

#include "engine/graph/file/nearest.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/read_graph.h"

namespace tactus {
namespace {

constexpr const char* kHowUnits = "write units as \"m/s\", \"N/m\", \"ms\", \"dB\" or \"full scale\"";

const Unit& seconds() {
  static const Unit unit = *parse_unit("s");
  return unit;
}

/// Both ends of a range, or nothing and a mistake.
std::optional<Interval> read_ends(const Field& field, const Unit& unit, const std::string& of,
                                  Mistakes& mistakes) {
  const auto& value = field.value;
  const auto owner = "'" + field.key + "'" + of;
  const auto* list = value.list();
  if (list == nullptr || list->size() != 2) {
    mistakes.add(Errc::WrongType, value.at, owner + " must have two ends",
                 "write " + field.key + " = [low, high]");
    return std::nullopt;
  }
  const auto low = read_quantity((*list)[0], unit, field.key);
  const auto high = read_quantity((*list)[1], unit, field.key);
  mistakes.keep(low);
  mistakes.keep(high);
  if (!low || !high) return std::nullopt;
  if (*low > *high) {
    mistakes.add(Errc::OutOfRange, value.at, owner + " is upside down", "write the lower end first");
    return std::nullopt;
  }
  return Interval{*low, *high};
}

void read_range(const EntrySpec& entry, FlatControl& control, Mistakes& mistakes) {
  const auto* value = find(entry.fields, "range");
  if (value == nullptr) return;
  const auto range =
      read_ends({"range", {}, *value}, control.unit, " of control '" + entry.name + "'", mistakes);
  if (!range) return;
  control.range = *range;
  if (!range->contains(control.value))
    mistakes.add(
        Errc::OutOfRange, find(entry.fields, "value")->at,
        "control '" + entry.name + "' starts at " + in_unit(control.value, control.unit) +
            ", which is outside its range",
        "it goes from " + in_unit(range->low, control.unit) + " to " + in_unit(range->high, control.unit));
}

void read_smooth(const EntrySpec& entry, FlatControl& control, Mistakes& mistakes) {
  const auto* value = find(entry.fields, "smooth");
  if (value == nullptr) return;
  const auto time = read_quantity(*value, seconds(), "smooth");
  if (mistakes.keep(time) == nullptr) return;
  if (*time < 0)
    mistakes.add(Errc::OutOfRange, value->at, "'smooth' cannot be negative",
                 "give a time, such as \"10 ms\"");
  else
    control.smooth_s = *time;
}

/// Where the control starts, and by its unit the control's. False after a mistake.
bool read_value(const EntrySpec& entry, FlatControl& control, Mistakes& mistakes) {
  const auto* value = find(entry.fields, "value");
  if (value == nullptr) {
    mistakes.add(Errc::Missing, entry.at, "control '" + entry.name + "' lacks 'value'",
                 "say where it starts, as in value = 0.5");
    return false;
  }
  const bool unit_given = find(entry.fields, "unit") != nullptr;
  if (unit_given && mistakes.keep(read_quantity(*value, control.unit, "value")) == nullptr) return false;
  const auto quantity = read_quantity(*value);
  if (!quantity) return mistakes.add(quantity.error()), false;
  control.value = quantity->si;
  if (!quantity->bare) control.unit = quantity->unit;
  control.decibel = control.unit.decibel;
  return true;
}

}  // namespace

std::string in_unit(double si, const Unit& unit) {
  if (unit.decibel) return short_number(unit.from_si(si)) + " dB";
  return short_quantity(si, unit.dimension);
}

void check_fields(const EntrySpec& entry, const std::vector<std::string>& known, const std::string& owner,
                  Mistakes& mistakes) {
  const std::unordered_set<std::string_view> names(known.begin(), known.end());
  for (const auto& field : entry.fields) {
    if (names.contains(field.key)) continue;
    const auto near = nearest_name(field.key, known);
    std::string list;
    for (const auto& key : known) list += (list.empty() ? "" : ", ") + key;
    mistakes.add(Errc::UnknownName, field.at, owner + " has no '" + field.key + "'",
                 near.empty() ? "it takes " + list : "did you mean '" + near + "'?");
  }
}

int read_whole_number(const Value& value, const std::string& what, int low, int high, Mistakes& mistakes) {
  const auto* number = value.number();
  if (number != nullptr && std::floor(*number) == *number && *number >= low && *number <= high)
    return static_cast<int>(*number);
  const bool whole = number != nullptr && std::floor(*number) == *number;
  mistakes.add(Errc::OutOfRange, value.at,
               "'" + what + (whole ? "' cannot be " + short_number(*number) : "' must be a whole number"),
               "give one from " + std::to_string(low) + " to " + std::to_string(high));
  return low;
}

std::optional<Unit> read_unit(const EntrySpec& entry, Mistakes& mistakes) {
  const auto* value = find(entry.fields, "unit");
  if (value == nullptr) return Unit{};
  if (value->text() == nullptr) {
    mistakes.add(Errc::WrongType, value->at, "'unit' must be a string, not " + value->kind(), kHowUnits);
    return std::nullopt;
  }
  const auto unit = parse_unit(*value->text());
  if (!unit) mistakes.add(Errc::UnknownName, value->at, "'" + *value->text() + "' is not a unit", kHowUnits);
  return unit;
}

FlatInput read_input(const EntrySpec& entry, Mistakes& mistakes) {
  check_fields(entry, input_fields().keys(), "input '" + entry.name + "'", mistakes);
  FlatInput input;
  input.name = entry.name;
  input.about = mistakes.text(entry.fields, "about");
  if (const auto* lanes = find(entry.fields, "lanes"))
    input.lanes = read_whole_number(*lanes, "lanes", 1, 1024, mistakes);
  return input;
}

ReadControl read_control(const EntrySpec& entry, Mistakes& mistakes) {
  check_fields(entry, control_fields().keys(), "control '" + entry.name + "'", mistakes);
  ReadControl read;
  auto& control = read.control;
  control.name = entry.name;
  control.about = mistakes.text(entry.fields, "about");
  const auto unit = read_unit(entry, mistakes);
  if (unit) control.unit = *unit;
  read.unit_known = unit && read_value(entry, control, mistakes);
  if (read.unit_known) read_range(entry, control, mistakes);
  read_smooth(entry, control, mistakes);
  return read;
}

OutputUse read_use(const EntrySpec& entry, Mistakes& mistakes) {
  const auto kind = mistakes.text(entry.fields, "kind");
  if (kind == "audio") return OutputUse::Audio;
  if (!kind.empty() && kind != "drive")
    mistakes.add(Errc::UnknownName, find(entry.fields, "kind")->at,
                 "an output cannot be of kind '" + kind + "'", "write \"drive\" or \"audio\"");
  return OutputUse::Drive;
}

void check_tested_delays(const EntrySpec& entry, Mistakes& mistakes) {
  check_fields(entry, graph_fields()["delay"].inside->keys(), "[delay]", mistakes);
  if (const auto* tested = find(entry.fields, "tested"))
    read_ends({"tested", {}, *tested}, seconds(), " of [delay]", mistakes);
}

std::optional<Interval> tested_delays(const GraphSpec& graph) {
  const auto* tested = graph.delay ? find(graph.delay->fields, "tested") : nullptr;
  if (tested == nullptr) return std::nullopt;
  Mistakes told_elsewhere{graph.file};
  return read_ends({"tested", {}, *tested}, seconds(), " of [delay]", told_elsewhere);
}

}  // namespace tactus
