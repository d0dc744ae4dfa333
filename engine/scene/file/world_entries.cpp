#include "engine/scene/file/world_entries.h"

#include <cstdio>

#include "engine/scene/file/scene_checks.h"

namespace tactus {
namespace {

/// The control of a part that a person strikes it with.
const std::string kStrike = "strike";

Value text_value(std::string text, const Source& at) { return {std::move(text), at}; }

const char* curve_name(Gesture::Curve curve) {
  return curve == Gesture::Curve::Step ? "step" : curve == Gesture::Curve::Smooth ? "smooth" : "linear";
}

Value written(const ControlValue& value, const Source& at) {
  if (!value.dimension || value.dimension->plain()) return {value.si, at};
  char number[32];
  std::snprintf(number, sizeof number, "%.17g ", value.si);
  return text_value(number + to_string(*value.dimension), at);
}

void put(Value::Table& fields, const std::string& port, const Value& value) {
  for (auto& field : fields)
    if (field.key == port) {
      field.value = value;
      return;
    }
  fields.push_back({port, value.at, value});
}

}  // namespace

NodeSpec gesture_node(const Gesture& gesture) {
  NodeSpec node;
  node.name = gesture.name;
  node.at = gesture.at;
  node.type = "curve";
  node.type_at = gesture.at;
  Value::List points;
  for (const auto& point : gesture.points) {
    Value::List pair{{point.time_s, gesture.at}, {point.value, gesture.at}};
    points.push_back({std::move(pair), gesture.at});
  }
  node.fields.push_back({"points", gesture.at, {std::move(points), gesture.at}});
  node.fields.push_back({"curve", gesture.at, text_value(curve_name(gesture.curve), gesture.at)});
  if (!gesture.bare)
    node.fields.push_back({"unit", gesture.at, text_value(to_string(gesture.unit.dimension), gesture.at)});
  node.broken = gesture.points.empty();
  return node;
}

void overwrite(Value::Table& fields, const std::string& port, const ControlValue& value, const Source& at) {
  put(fields, port, written(value, at));
}

void strike_by_hand(const GraphSpec& part, NodeSpec& node, GraphSpec& world) {
  if (find_entry(part.controls, kStrike) == nullptr) return;
  const auto& at = node.at;
  if (find_entry(world.controls, kStrike) == nullptr) {
    const Value::List ends{{0.0, at}, {1.0, at}};
    world.controls.push_back(
        {kStrike,
         at,
         {{"value", at, {0.0, at}}, {"range", at, {ends, at}}, {"smooth", at, text_value("0 ms", at)}}});
  }
  put(node.fields, kStrike, text_value(kStrike, at));
}

}  // namespace tactus
