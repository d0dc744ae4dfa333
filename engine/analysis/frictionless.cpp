#include "engine/analysis/frictionless.h"

#include <memory>

namespace tactus {
namespace {

std::shared_ptr<const GraphSpec> let_slide(const GraphSpec& graph) {
  auto changed = std::make_shared<GraphSpec>(graph);
  for (auto& network : changed->networks)
    for (auto& element : network.elements) {
      if (element.type != "friction") continue;
      std::erase_if(element.fields, [](const Field& field) { return field.key == "normal"; });
      element.fields.push_back({"normal", element.at, {0.0, element.at}});
    }
  for (auto& [name, part] : changed->parts) part = let_slide(*part);
  return changed;
}

}  // namespace

LoadedScene without_friction(LoadedScene loaded) {
  if (loaded.scene)
    for (auto& part : loaded.scene->parts)
      if (part.graph != nullptr) part.graph = let_slide(*part.graph);
  return loaded;
}

}  // namespace tactus
