#include "engine/study/stability/frictionless.h"

#include <utility>

#include "engine/nodes/networks/network_elements.h"
#include "engine/study/sweep/scene_variants.h"

namespace tactus {
namespace {

void let_slide(NetworkSpec& network, const std::string&) {
  for (auto& element : network.elements) {
    const auto* type = find_element(element.type);
    if (type == nullptr || type->force_field.empty()) continue;
    std::erase_if(element.fields, [&](const Field& field) { return field.key == type->force_field; });
    element.fields.push_back({type->force_field, element.at, {0.0, element.at}});
  }
}

}  // namespace

LoadedScene without_friction(LoadedScene loaded) {
  if (loaded.scene) loaded.scene = with_networks_changed(std::move(*loaded.scene), let_slide);
  return loaded;
}

}  // namespace tactus
