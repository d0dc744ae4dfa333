#include "engine/core/index.h"
#include "engine/graph/file/read_graph.h"

namespace tactus {
namespace {

std::string owner_of(const char* kind, const EntrySpec& entry) {
  return std::string{kind} + " '" + entry.name + "'";
}

/// Where the control starts, and by its unit the control's. False after an error.
bool read_value(const EntrySpec& entry, FlatControl& control, Mistakes& mistakes) {
  const auto* value = find(entry.fields, "value");
  if (value == nullptr) {
    mistakes.add(Errc::Missing, entry.at, "control '" + entry.name + "' lacks 'value'",
                 "give its start value, as in value = 0.5");
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

void read_range(const EntrySpec& entry, FieldReader& fields, FlatControl& control, Mistakes& mistakes) {
  const auto range = fields.range("range", control.unit);
  if (!range) return;
  control.range = *range;
  if (!range->contains(control.value))
    mistakes.add(Errc::OutOfRange, fields.value("value")->at,
                 "control '" + entry.name + "' starts at " + in_unit(control.value, control.unit) +
                     ", which is outside its range",
                 limits_text(range->low, range->high, control.unit));
}

}  // namespace

std::optional<Unit> read_unit(const EntrySpec& entry, Mistakes& mistakes) {
  constexpr const char* kUnits = "write units as \"m/s\", \"N/m\", \"ms\", \"dB\" or \"full scale\"";
  const auto* value = find(entry.fields, "unit");
  if (value == nullptr) return Unit{};
  if (value->text() == nullptr) {
    mistakes.add(Errc::WrongType, value->at, "'unit' must be a string, not " + value->kind(), kUnits);
    return std::nullopt;
  }
  const auto unit = parse_unit(*value->text());
  if (!unit) mistakes.add(Errc::UnknownName, value->at, "'" + *value->text() + "' is not a unit", kUnits);
  return unit;
}

FlatInput read_input(const EntrySpec& entry, Mistakes& mistakes) {
  FieldReader fields{entry.fields, input_fields(), mistakes, owner_of("input", entry)};
  return {entry.name, static_cast<int>(fields.number("lanes").value_or(1)), {}};
}

ReadControl read_control(const EntrySpec& entry, Mistakes& mistakes) {
  FieldReader fields{entry.fields, control_fields(), mistakes, owner_of("control", entry)};
  ReadControl read;
  auto& control = read.control;
  control.name = entry.name;
  const auto unit = read_unit(entry, mistakes);
  if (unit) control.unit = *unit;
  read.unit_known = unit && read_value(entry, control, mistakes);
  if (read.unit_known) read_range(entry, fields, control, mistakes);
  control.smooth_s = fields.number("smooth").value_or(control.smooth_s);
  return read;
}

OutputUse read_use(const EntrySpec& entry, Mistakes& mistakes) {
  FieldReader fields{entry.fields, output_fields(), mistakes, FieldReader::kKeysChecked,
                     owner_of("output", entry)};
  return fields.choice("kind").value_or(0) == 1 ? OutputUse::Audio : OutputUse::Drive;
}

std::optional<Interval> tested_delays(const GraphSpec& graph, Mistakes& mistakes) {
  if (!graph.delay) return std::nullopt;
  FieldReader fields{graph.delay->fields, *graph_fields()["delay"].inside, mistakes, "[delay]"};
  return fields.range("tested", *parse_unit("s"));
}

std::optional<Interval> tested_delays(const GraphSpec& graph) {
  Mistakes reported_elsewhere{graph.file};
  return tested_delays(graph, reported_elsewhere);
}

}  // namespace tactus
