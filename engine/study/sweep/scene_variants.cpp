#include "engine/study/sweep/scene_variants.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <utility>

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
  return found != type.fields.end() && !found->late &&
         std::find(kPlaces.begin(), kPlaces.end(), field) == kPlaces.end();
}

void redraw(NodeSpec& element, const std::string& path, const Draw& rule) {
  const auto* type = find_element(element.type);
  if (type == nullptr) return;
  for (auto& field : element.fields)
    if (is_material(*type, field.key))
      field.value = times(field.value, 1 + rule.within * draw(rule.seed, path + "." + field.key));
}

std::shared_ptr<const GraphSpec> changed(const GraphSpec& graph, const std::string& path,
                                         const NetworkChange& change) {
  auto copy = std::make_shared<GraphSpec>(graph);
  for (auto& network : copy->networks) change(network, path + "." + network.name);
  for (auto& [name, part] : copy->parts) part = changed(*part, path + "." + name, change);
  return copy;
}

void change_part(ScenePart& part, const NetworkChange& change) {
  if (part.graph != nullptr) part.graph = changed(*part.graph, part.name, change);
}

bool any_network(const GraphSpec& graph, const std::function<bool(const NetworkSpec&)>& condition) {
  return std::any_of(graph.networks.begin(), graph.networks.end(), condition) ||
         std::any_of(graph.parts.begin(), graph.parts.end(),
                     [&](const auto& part) { return any_network(*part.second, condition); });
}

bool any_network(const SceneSpec& scene, const std::function<bool(const NetworkSpec&)>& condition) {
  return std::any_of(scene.parts.begin(), scene.parts.end(), [&](const ScenePart& part) {
    return part.name != "instrument" && part.graph != nullptr && any_network(*part.graph, condition);
  });
}

using ConstantVisit = std::function<void(const std::string& name)>;

void visit_fields(const NodeSpec& node, const std::string& path, const ConstantVisit& visit) {
  for (const auto& field : node.fields)
    if (read_quantity(field.value)) visit(path + "." + field.key);
}

void visit_constants(const GraphSpec& graph, const std::string& path, const ConstantVisit& visit) {
  for (const auto& node : graph.nodes) {
    const auto name = path + "." + node.name;
    if (const auto part = graph.parts.find(node.use); part != graph.parts.end())
      visit_constants(*part->second, name, visit);
    visit_fields(node, name, visit);
    if (node.value && read_quantity(*node.value)) visit(name);
  }
  for (const auto& network : graph.networks)
    for (const auto& element : network.elements)
      visit_fields(element, path + "." + network.name + "." + element.name, visit);
}

/// Whether `name` is "path" or begins with "path."; then without it.
bool take_prefix(std::string_view& name, std::string_view path) {
  if (!name.starts_with(path)) return false;
  if (name.size() > path.size() && name[path.size()] != '.') return false;
  name.remove_prefix(std::min(name.size(), path.size() + 1));
  return true;
}

bool set_field(NodeSpec& node, std::string_view key, const Value& value) {
  for (auto& field : node.fields)
    if (field.key == key) {
      field.value.data = value.data;
      return true;
    }
  return false;
}

bool set_constant(GraphSpec& graph, std::string_view name, const Value& value) {
  for (auto& node : graph.nodes) {
    auto rest = name;
    if (!take_prefix(rest, node.name)) continue;
    if (rest.empty() && node.value) return node.value->data = value.data, true;
    if (set_field(node, rest, value)) return true;
    const auto part = graph.parts.find(node.use);
    if (part == graph.parts.end()) continue;
    auto copy = std::make_shared<GraphSpec>(*part->second);
    if (!set_constant(*copy, rest, value)) continue;
    node.use += "#" + node.name;
    graph.parts[node.use] = std::move(copy);
    return true;
  }
  for (auto& network : graph.networks)
    for (auto& element : network.elements) {
      auto rest = name;
      if (take_prefix(rest, network.name + "." + element.name) && set_field(element, rest, value))
        return true;
    }
  return false;
}

SceneSpec with_world_changed(SceneSpec scene, const NetworkChange& change) {
  for (auto& part : scene.parts)
    if (part.name != "instrument") change_part(part, change);
  return scene;
}

}  // namespace

SceneSpec with_networks_changed(SceneSpec scene, const NetworkChange& change) {
  for (auto& part : scene.parts) change_part(part, change);
  return scene;
}

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

std::vector<std::string> constant_names(const SceneSpec& scene) {
  std::vector<std::string> names;
  for (const auto& part : scene.parts)
    if (part.graph != nullptr)
      visit_constants(*part.graph, part.name, [&](const std::string& name) { names.push_back(name); });
  return names;
}

SceneSpec with_constant(SceneSpec scene, const std::string& name, const ControlValue& value) {
  const Value written{value.dimension
                          ? decltype(Value::data){fmt::format("{} {}", value.si, to_string(*value.dimension))}
                          : decltype(Value::data){value.si},
                      {}};
  for (auto& part : scene.parts) {
    std::string_view rest = name;
    if (part.graph == nullptr || !take_prefix(rest, part.name)) continue;
    auto copy = std::make_shared<GraphSpec>(*part.graph);
    if (set_constant(*copy, rest, written)) part.graph = std::move(copy);
  }
  return scene;
}

SceneSpec with_network_option(SceneSpec scene, const std::string& key, decltype(Value::data) value) {
  return with_world_changed(std::move(scene), [&](NetworkSpec& network, const std::string&) {
    std::erase_if(network.options, [&](const Field& field) { return field.key == key; });
    network.options.push_back({key, network.at, {value, network.at}});
  });
}

std::vector<std::string> stepping_solvers() {
  std::vector<std::string> words;
  for (const auto solver : kSolvers)
    if (solver != Solver::Auto && solver != Solver::Reference) words.emplace_back(name_of(solver));
  return words;
}

bool is_linear(const SceneSpec& scene) {
  return !any_network(scene, [](const NetworkSpec& network) {
    return std::any_of(network.elements.begin(), network.elements.end(), [](const NodeSpec& element) {
      const auto* type = find_element(element.type);
      return type == nullptr || !type->linear ||
             std::any_of(type->fields.begin(), type->fields.end(), [&](const ElementField& field) {
               return field.nonlinear && find(element.fields, field.name) != nullptr;
             });
    });
  });
}

bool has_network(const SceneSpec& scene) {
  return any_network(scene, [](const NetworkSpec&) { return true; });
}

}  // namespace tactus
