#include "engine/study/playability/changed_networks.h"

#include <memory>

namespace tactus {
namespace {

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

}  // namespace

SceneSpec with_networks_changed(SceneSpec scene, const NetworkChange& change) {
  for (auto& part : scene.parts) change_part(part, change);
  return scene;
}

SceneSpec with_world_changed(SceneSpec scene, const NetworkChange& change) {
  for (auto& part : scene.parts)
    if (part.name != "instrument") change_part(part, change);
  return scene;
}

}  // namespace tactus
