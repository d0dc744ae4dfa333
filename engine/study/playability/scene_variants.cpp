#include "engine/study/playability/scene_variants.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "engine/graph/plan/fingerprint.h"
#include "engine/nodes/networks/network_elements.h"
#include "engine/study/playability/changed_networks.h"

namespace tactus {
namespace {

// Fields that say where something is, not what it is made of; and those with a bound of their own.
constexpr std::array kPlaces = {"at", "velocity", "rest", "offset", "exponent", "restitution", "bandwidth"};

/// What is written, times a number.
Value times(const Value& value, double factor) {
  auto scaled = value;
  if (const auto* number = value.number())
    scaled.data = *number * factor;
  else if (const auto* text = value.text())
    scaled.data = fmt::format("{} * ({})", factor, *text);
  else if (const auto* list = value.list()) {
    Value::List lanes;
    for (const auto& lane : *list) lanes.push_back(times(lane, factor));
    scaled.data = std::move(lanes);
  }
  return scaled;
}

bool names_instrument(const Value& value) {
  if (const auto* text = value.text()) return text->find("instrument.") != std::string::npos;
  const auto* list = value.list();
  return list != nullptr && std::any_of(list->begin(), list->end(), names_instrument);
}

/// -1 to 1, evenly: the upper 53 bits of a hash. The finishing steps of splitmix64 (Steele, Lea and Flood,
/// OOPSLA 2014) make neighbouring seeds independent.
double draw(std::uint64_t seed, const std::string& name) {
  auto bits = Fingerprint{}.add(seed).add(name).value();
  bits = (bits ^ bits >> 30) * 0xbf58476d1ce4e5b9u;
  bits = (bits ^ bits >> 27) * 0x94d049bb133111ebu;
  bits ^= bits >> 31;
  return 2 * static_cast<double>(bits >> 11) * 0x1p-53 - 1;
}

struct Draw {
  double within;
  std::uint64_t seed;
};

bool is_material(const ElementType& type, const std::string& field) {
  const auto found = std::find_if(type.fields.begin(), type.fields.end(),
                                  [&](const ElementField& known) { return known.name == field; });
  return found != type.fields.end() && !found->signal &&
         std::find(kPlaces.begin(), kPlaces.end(), field) == kPlaces.end();
}

void redraw(NodeSpec& element, const std::string& path, const Draw& rule) {
  const auto* type = find_element(element.type);
  if (type == nullptr) return;
  for (auto& field : element.fields)
    if (is_material(*type, field.key))
      field.value = times(field.value, 1 + rule.within * draw(rule.seed, path + "." + field.key));
}

}  // namespace

SceneSpec with_actuator_gain(SceneSpec scene, double gain) {
  for (auto& part : scene.parts)
    for (auto& wire : part.wires)
      if (part.name != "instrument" && names_instrument(wire.value)) wire.value = times(wire.value, gain);
  return scene;
}

SceneSpec with_plant_drawn(SceneSpec scene, double within, std::uint64_t seed) {
  return with_world_changed(std::move(scene), [&](NetworkSpec& network, const std::string& path) {
    for (auto& element : network.elements) redraw(element, path + "." + element.name, {within, seed});
  });
}

SceneSpec with_gesture_scaled(SceneSpec scene, const std::string& gesture, double factor) {
  for (auto& candidate : scene.gestures)
    if (candidate.name == gesture)
      for (auto& point : candidate.points) point.value *= factor;
  return scene;
}

SceneSpec with_gesture_held(SceneSpec scene, const std::string& gesture, double value) {
  for (auto& candidate : scene.gestures)
    if (candidate.name == gesture) candidate.points = {{0, value}};
  return scene;
}

}  // namespace tactus
