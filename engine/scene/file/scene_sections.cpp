#include "engine/scene/file/scene_sections.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/read_graph.h"
#include "engine/graph/semantics/scope.h"
#include "engine/scene/file/scene_fields.h"

namespace tactus {
namespace {

std::string seconds_text(double seconds) {
  return short_quantity(seconds, parse_unit("s").value().dimension);
}

// ---- gestures ----

/// Reads the points of one gesture; each point with a mistake is reported and left out.
class PointReader {
 public:
  PointReader(Gesture& gesture, ErrorList& mistakes) : gesture_(gesture), mistakes_(mistakes) {
    gesture_.bare = true;
  }

  void read(const Value& point) {
    const auto* pair = point.list();
    if (pair == nullptr || pair->size() != 2)
      return mistakes_.add(Errc::WrongType, point.at, "a point is a time and a value",
                           "write it as in [\"0.1 s\", \"2 m/s\"]");
    const auto time = read_time((*pair)[0]);
    const auto value = read_value((*pair)[1]);
    if (time && value) gesture_.points.push_back({*time, *value});
  }

 private:
  std::optional<double> read_time(const Value& value) {
    const auto time = read_quantity(value, parse_unit("s").value(), "time");
    if (mistakes_.keep(time) == nullptr) return std::nullopt;
    if (*time < 0 || *time > kLongestTime_s) {
      mistakes_.add(Errc::OutOfRange, value.at, "a gesture cannot be at " + seconds_text(*time),
                    "times run from 0 s to a day");
    } else if (*time <= last_s_) {
      mistakes_.add(Errc::OutOfRange, value.at,
                    seconds_text(*time) + " does not come after " + seconds_text(last_s_) + " before it",
                    "the times of a gesture increase");
    }
    last_s_ = std::max(last_s_, *time);
    return *time;
  }

  std::optional<double> read_value(const Value& value) {
    const auto quantity = read_quantity(value);
    if (mistakes_.keep(quantity) == nullptr) return std::nullopt;
    if (quantity->bare) return quantity->si;
    if (std::exchange(gesture_.bare, false)) gesture_.unit = quantity->unit;
    const auto checked = read_quantity(value, gesture_.unit, gesture_.name);
    return mistakes_.keep(checked) == nullptr ? std::nullopt : std::optional{*checked};
  }

  Gesture& gesture_;
  ErrorList& mistakes_;
  double last_s_ = -1;
};

Gesture read_gesture(const EntrySpec& entry, ErrorList& mistakes) {
  Gesture gesture;
  gesture.name = entry.name;
  gesture.at = entry.at;
  FieldReader fields{entry.fields, gesture_fields(), mistakes};
  gesture.curve = static_cast<Gesture::Curve>(fields.choice("curve").value_or(0));
  if (entry.broken) return gesture;
  const auto* points = fields.value("points");
  if (points == nullptr || points->list() == nullptr || points->list()->empty()) {
    mistakes.add(Errc::Missing, points ? points->at : entry.at, "gesture '" + entry.name + "' has no points",
                 "write points = [[\"0 s\", 0], [\"1 s\", 1]]");
    return gesture;
  }
  PointReader reader{gesture, mistakes};
  for (const auto& point : *points->list()) reader.read(point);
  return gesture;
}

// ---- expectations ----

void check_limits(const Expectation& expectation, const Value::Table& fields, ErrorList& mistakes) {
  const auto &min = expectation.min, &max = expectation.max;
  if (find(fields, "min") == nullptr && find(fields, "max") == nullptr)
    mistakes.add(Errc::Missing, expectation.at, "'" + expectation.name + "' expects nothing",
                 "give 'min', 'max' or both");
  if (!min || !max) return;
  if (!min->bare && !max->bare && !(min->unit.dimension == max->unit.dimension))
    mistakes.add(Errc::UnitMismatch, find(fields, "max")->at, "'min' and 'max' are in different units",
                 "give both in the same");
  else if (min->si > max->si)
    mistakes.add(Errc::OutOfRange, find(fields, "max")->at, "'max' lies below 'min'", "swap them");
}

Expectation read_expectation(const EntrySpec& entry, Seconds duration, ErrorList& mistakes) {
  FieldReader fields{entry.fields, expectation_fields(), mistakes};
  Expectation expectation;
  expectation.name = entry.name;
  expectation.at = entry.at;
  expectation.measure = fields.text("measure");
  expectation.measure_at = fields.at("measure", entry.at);
  expectation.of = fields.text("of");
  expectation.of_at = fields.at("of", entry.at);
  if (!fields.has("measure"))
    mistakes.add(Errc::Missing, entry.at, "'" + entry.name + "' says nothing to measure",
                 "write measure = \"…\" with what is meant");
  std::tie(expectation.from_s, expectation.to_s) = fields.window(duration);
  expectation.min = fields.any("min");
  expectation.max = fields.any("max");
  check_limits(expectation, entry.fields, mistakes);
  return expectation;
}

void read_compared(const Field& field, const std::string& name, Comparison& comparison, ErrorList& mistakes) {
  const auto value = read_quantity(field.value);
  if (mistakes.keep(value) == nullptr) return;
  comparison.set[name] = value->si;
  comparison.places[name] = field.at;
}

}  // namespace

std::vector<Gesture> read_gestures(const Value::Table& scene, ErrorList& mistakes) {
  std::vector<Gesture> gestures;
  for (const auto& entry :
       read_entries(scene, "gestures", "{ points = [[\"0 s\", 0], [\"1 s\", 1]] }", mistakes))
    gestures.push_back(read_gesture(entry, mistakes));
  return gestures;
}

Converters read_converters(const Value::Table& scene, ErrorList& mistakes) {
  Converters converters;
  const auto* section = read_section(scene, "converters", mistakes);
  if (section == nullptr) return converters;
  FieldReader fields{*section, converter_fields(), mistakes};
  if (const auto bits = fields.number("bits")) converters.bits = static_cast<int>(*bits);
  converters.on = !fields.flag("off");
  if (!converters.on && fields.has("bits"))
    mistakes.add(Errc::Duplicate, fields.value("off")->at, "converters that are off have no bits",
                 "remove 'off' or 'bits'");
  return converters;
}

std::vector<Expectation> read_expectations(const Value::Table& scene, Seconds duration, ErrorList& mistakes) {
  std::vector<Expectation> expectations;
  NameSpace names;
  for (const auto& entry : read_entries(scene, "expect", "{ measure = \"…\", max = 1 }", mistakes)) {
    names.add(entry.name, "an expectation", entry.at, mistakes);
    expectations.push_back(read_expectation(entry, duration, mistakes));
  }
  return expectations;
}

std::optional<Comparison> read_comparison(const Value::Table& scene, ErrorList& mistakes) {
  const auto* fields = read_section(scene, "compare", mistakes);
  if (fields == nullptr) return std::nullopt;
  Comparison comparison{mistakes.text(*fields, "name"), find(scene, "compare")->at, {}, {}};
  if (comparison.name.empty())
    mistakes.add(Errc::Missing, comparison.at, "[compare] lacks 'name'",
                 "write name = \"without the pulse\"");
  for (const auto& field : *fields) {
    if (field.key == "name") continue;
    const auto* part = field.value.table();  // plant.gain = 1
    if (part == nullptr) read_compared(field, field.key, comparison, mistakes);
    for (const auto& inner : part != nullptr ? *part : Value::Table{})
      read_compared(inner, field.key + "." + inner.key, comparison, mistakes);
  }
  return comparison;
}

}  // namespace tactus
