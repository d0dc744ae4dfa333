#include "engine/study/sweep/scene_variants.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <utility>

#include "engine/core/named.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/plan/fingerprint.h"
#include "engine/nodes/networks/network_elements.h"
#include "engine/nodes/networks/solver_names.h"

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
  return list != nullptr && std::ranges::any_of(*list, names_instrument);
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

bool is_material(const std::string& element, const std::string& field) {
  const auto* type = find_element(element);
  const auto* found = type != nullptr ? find_named(type->fields, field) : nullptr;
  return found != nullptr && !found->late && std::ranges::find(kPlaces, field) == kPlaces.end();
}

std::shared_ptr<const GraphSpec> changed(const GraphSpec& graph, const std::string& path,
                                         const NetworkChange& change) {
  auto copy = std::make_shared<GraphSpec>(graph);
  for (auto& network : copy->networks) change(network, path + "." + network.name);
  for (auto& [name, part] : copy->parts) part = changed(*part, path + "." + name, change);
  return copy;
}

/// Gets each constant with its name; true: it was changed, and no further one is visited.
using ConstantVisit = std::function<bool(const std::string& name, Value& value)>;

bool visit_fields(NodeSpec& node, const std::string& path, const ConstantVisit& visit) {
  return std::ranges::any_of(node.fields, [&](Field& field) {
    return read_quantity(field.value) && visit(path + "." + field.key, field.value);
  });
}

/// A part that is used twice is changed in one place only.
bool visit_constants(GraphSpec& graph, const std::string& path, const ConstantVisit& visit) {
  for (auto& node : graph.nodes) {
    const auto name = path + "." + node.name;
    if (const auto part = graph.parts.find(node.use); part != graph.parts.end())
      if (auto copy = std::make_shared<GraphSpec>(*part->second); visit_constants(*copy, name, visit)) {
        node.use += "#" + node.name;
        graph.parts[node.use] = std::move(copy);
        return true;
      }
    if (visit_fields(node, name, visit)) return true;
    if (node.value && read_quantity(*node.value) && visit(name, *node.value)) return true;
  }
  for (auto& network : graph.networks)
    for (auto& element : network.elements)
      if (visit_fields(element, path + "." + network.name + "." + element.name, visit)) return true;
  return false;
}

}  // namespace

SceneSpec with_networks_changed(SceneSpec scene, const NetworkChange& change, bool instrument) {
  for (auto& part : scene.parts)
    if (part.graph != nullptr && (instrument || part.name != "instrument"))
      part.graph = changed(*part.graph, part.name, change);
  return scene;
}

SceneSpec with_actuator_gain(SceneSpec scene, double gain) {
  for (auto& part : scene.parts)
    for (auto& wire : part.wires)
      if (part.name != "instrument" && names_instrument(wire.value)) wire.value = times(wire.value, gain);
  return scene;
}

SceneSpec with_plant_drawn(SceneSpec scene, double within, std::uint64_t seed) {
  const auto redraw = [&](NetworkSpec& network, const std::string& path) {
    for (auto& element : network.elements)
      for (auto& field : element.fields)
        if (is_material(element.type, field.key))
          field.value =
              times(field.value, 1 + within * draw(seed, path + "." + element.name + "." + field.key));
  };
  return with_networks_changed(std::move(scene), redraw, false);
}

SceneSpec with_gesture_scaled(SceneSpec scene, const std::string& gesture, double factor) {
  for (auto& point : find_named(scene.gestures, gesture)->points) point.value *= factor;
  return scene;
}

SceneSpec with_gesture_held(SceneSpec scene, const std::string& gesture, double value) {
  find_named(scene.gestures, gesture)->points = {{0, value}};
  return scene;
}

std::vector<std::string> constant_names(const SceneSpec& scene) {
  std::vector<std::string> names;
  for (const auto& part : scene.parts)
    if (part.graph != nullptr) {
      GraphSpec copy = *part.graph;
      visit_constants(copy, part.name, [&](const std::string& name, Value&) {
        names.push_back(name);
        return false;
      });
    }
  return names;
}

SceneSpec with_constant(SceneSpec scene, const std::string& name, const ControlValue& value) {
  const auto set = [&](const std::string& candidate, Value& constant) {
    if (candidate != name) return false;
    if (value.dimension)
      constant.data = fmt::format("{} {}", value.si, to_string(*value.dimension));
    else
      constant.data = value.si;
    return true;
  };
  for (auto& part : scene.parts) {
    if (part.graph == nullptr || !name.starts_with(part.name + ".")) continue;
    auto copy = std::make_shared<GraphSpec>(*part.graph);
    if (visit_constants(*copy, part.name, set)) part.graph = std::move(copy);
  }
  return scene;
}

SceneSpec with_network_option(SceneSpec scene, const std::string& key, decltype(Value::data) value) {
  return with_networks_changed(
      std::move(scene),
      [&](NetworkSpec& network, const std::string&) {
        std::erase_if(network.fields, [&](const Field& field) { return field.key == key; });
        network.fields.push_back({key, network.at, {value, network.at}});
      },
      false);
}

std::vector<std::string> stepping_solvers() {
  std::vector<std::string> names;
  for (const auto solver : kSolvers)
    if (solver != Solver::Auto && solver != Solver::Reference) names.emplace_back(name_of(solver));
  return names;
}

bool is_linear(const SceneSpec& scene) {
  bool linear = true;
  const auto look = [&](const NetworkSpec& network, const std::string&) {
    for (const auto& element : network.elements) {
      const auto* type = find_element(element.type);
      linear = linear && type != nullptr && type->linear &&
               std::ranges::none_of(type->fields, [&](const ElementField& field) {
                 return field.nonlinear && find(element.fields, field.name) != nullptr;
               });
    }
  };
  with_networks_changed(scene, look, false);
  return linear;
}

bool has_network(const SceneSpec& scene) {
  bool found = false;
  with_networks_changed(
      scene, [&](NetworkSpec&, const std::string&) { found = true; }, false);
  return found;
}

}  // namespace tactus
