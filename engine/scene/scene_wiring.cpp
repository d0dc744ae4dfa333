#include "engine/scene/scene_wiring.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/named.h"
#include "engine/graph/file/read_graph.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {
namespace {

/// The control of a part that a person strikes it with.
const std::string kStrike = "strike";

Value text_value(std::string text, const Source& at) { return {std::move(text), at}; }

Value value_of(const ControlValue& value, const Source& at) {
  if (!value.dimension || value.dimension->plain()) return {value.si, at};
  return text_value(fmt::format("{:.17g} {}", value.si, to_string(*value.dimension)), at);
}

void put(Value::Table& fields, const std::string& port, const Value& value) {
  if (const auto found = std::ranges::find(fields, port, &Field::key); found != fields.end())
    found->value = value;
  else
    fields.push_back({port, value.at, value});
}

std::string range_text(const FlatControl& control) {
  return "it runs from " + in_unit(control.range.low, control.unit) + " to " +
         in_unit(control.range.high, control.unit);
}

void check_gesture(const Gesture& gesture, const FlatControl& control, const Source& at, ErrorList& errors) {
  if (!gesture.bare && !(gesture.unit.dimension == control.unit.dimension))
    return errors.add(Errc::UnitMismatch, at,
                      "control '" + control.name + "' has the unit of " +
                          in_unit(control.value, control.unit) + ", but gesture '" + gesture.name +
                          "' has the unit of " + in_unit(gesture.points.front().value, gesture.unit),
                      "write the points of the gesture in the unit of the control");
  for (const auto& point : gesture.points)
    if (!control.range.contains(point.value))
      return errors.add(Errc::OutOfRange, at,
                        "gesture '" + gesture.name + "' sets control '" + control.name + "' to " +
                            in_unit(point.value, control.unit) + ", which is outside its range",
                        range_text(control));
}

/// Of a gesture over a long time, points a millisecond apart would be too many to keep.
double step_of(const std::vector<Gesture::Point>& points) {
  constexpr double kMaxSteps = 1e6;
  return std::max(1e-3, (points.back().time_s - points.front().time_s) / kMaxSteps);
}

void add_slope(const Gesture::Point& from, const Gesture::Point& to, Gesture::Curve curve, double step_s,
               const auto& add) {
  for (double t = from.time_s + step_s; t < to.time_s; t += step_s) {
    double u = (t - from.time_s) / (to.time_s - from.time_s);
    if (curve == Gesture::Curve::Smooth) u = u * u * (3 - 2 * u);
    add(t, from.value + (to.value - from.value) * u);
  }
}

}  // namespace

NodeSpec gesture_node(const Gesture& gesture) {
  NodeSpec node;
  node.name = gesture.name;
  node.type = "curve";
  node.at = node.type_at = gesture.at;
  const auto curve = static_cast<std::size_t>(gesture.curve);
  Value::List points;
  for (const auto& point : gesture.points) {
    Value::List pair{{point.time_s, gesture.at}, {point.value, gesture.at}};
    points.push_back({std::move(pair), gesture.at});
  }
  node.fields.push_back({"points", gesture.at, {std::move(points), gesture.at}});
  node.fields.push_back(
      {"curve", gesture.at,
       text_value((*scene_fields()["gestures"].inside)["curve"].choices[curve], gesture.at)});
  if (!gesture.bare)
    node.fields.push_back({"unit", gesture.at, text_value(to_string(gesture.unit.dimension), gesture.at)});
  node.broken = gesture.points.empty();
  return node;
}

void overwrite(Value::Table& fields, const std::string& port, const ControlValue& value, const Source& at) {
  put(fields, port, value_of(value, at));
}

void strike_by_hand(const GraphSpec& part, NodeSpec& node, GraphSpec& world) {
  if (find_named(part.controls, kStrike) == nullptr) return;
  const auto& at = node.at;
  if (find_named(world.controls, kStrike) == nullptr) {
    world.controls.push_back({{kStrike, at, {}}, {.name = kStrike, .range = {0, 1}, .smooth_s = 0}});
  }
  put(node.fields, kStrike, text_value(kStrike, at));
}

bool check_range(const FlatControl& control, double value, const Source& at, ErrorList& errors) {
  if (control.range.contains(value)) return true;
  errors.add(Errc::OutOfRange, at,
             "control '" + control.name + "' cannot be set to " + in_unit(value, control.unit),
             range_text(control));
  return false;
}

std::optional<WiredControl> wire_control(const SceneSpec& scene, const ControlSpec& entry, const Field& field,
                                         ErrorList& errors) {
  if (entry.broken) return std::nullopt;
  const auto& control = entry.control;
  const auto* text = field.value.text();
  if (const auto* gesture = text != nullptr ? scene.gesture(*text) : nullptr) {
    if (gesture->points.empty()) return std::nullopt;
    if (entry.unit_known) check_gesture(*gesture, control, field.value.at, errors);
    return WiredControl{gesture->points.front().value, gesture};
  }
  if (text != nullptr && !parse_quantity(*text)) {
    if (!scene.incomplete)
      errors.add(Errc::WrongType, field.value.at,
                 "'" + *text + "' is neither a value for control '" + control.name + "' nor a gesture",
                 "give a number or a quantity, or the name of a gesture");
    return std::nullopt;
  }
  if (!entry.unit_known) return std::nullopt;
  const auto value = read_quantity(field.value, control.unit, control.name);
  if (errors.keep(value) == nullptr) return std::nullopt;
  if (!check_range(control, *value, field.value.at, errors)) return std::nullopt;
  return WiredControl{*value, nullptr};
}

std::vector<JournalEntry> gesture_journal(const std::vector<MovedControl>& moved, const Plan& schedule) {
  std::vector<JournalEntry> entries;
  for (const auto& [control, gesture] : moved) {
    const int index = schedule.control_index(control);
    const auto add = [&](double time_s, double value) {
      entries.push_back({std::lround(time_s * schedule.sample_rate.value), JournalEntry::Kind::ControlChange,
                         index, value});
    };
    const auto& points = gesture->points;
    for (std::size_t i = 0; i < points.size(); ++i) {
      add(points[i].time_s, points[i].value);
      if (gesture->curve != Gesture::Curve::Step && i + 1 < points.size())
        add_slope(points[i], points[i + 1], gesture->curve, step_of(points), add);
    }
  }
  std::ranges::stable_sort(entries, {}, &JournalEntry::frame);
  return entries;
}

}  // namespace tactus
