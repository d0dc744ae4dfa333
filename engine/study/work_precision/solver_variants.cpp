#include "engine/study/work_precision/solver_variants.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "engine/nodes/networks/network_elements.h"
#include "engine/nodes/networks/solver_names.h"
#include "engine/study/playability/changed_networks.h"

namespace tactus {
namespace {

void set(Value::Table& options, const std::string& key, Value value) {
  std::erase_if(options, [&](const Field& field) { return field.key == key; });
  options.push_back({key, value.at, value});
}

bool any_network(const GraphSpec& graph, const std::function<bool(const NetworkSpec&)>& holds) {
  return std::any_of(graph.networks.begin(), graph.networks.end(), holds) ||
         std::any_of(graph.parts.begin(), graph.parts.end(),
                     [&](const auto& part) { return any_network(*part.second, holds); });
}

bool any_network(const SceneSpec& scene, const std::function<bool(const NetworkSpec&)>& holds) {
  return std::any_of(scene.parts.begin(), scene.parts.end(), [&](const ScenePart& part) {
    return part.name != "instrument" && part.graph != nullptr && any_network(*part.graph, holds);
  });
}

}  // namespace

std::string to_string(const SolverVariant& variant) {
  if (variant.oversample == 0) return fmt::format("{} at {:g} kHz", variant.solver, variant.rate.value / 1e3);
  return fmt::format("{} x {} at {:g} kHz", variant.solver, variant.oversample, variant.rate.value / 1e3);
}

SceneSpec with_solver(SceneSpec scene, const SolverVariant& variant) {
  return with_world_changed(std::move(scene), [&](NetworkSpec& network, const std::string&) {
    set(network.options, "solver", {variant.solver, network.at});
    set(network.options, "oversample", {static_cast<double>(variant.oversample), network.at});
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
