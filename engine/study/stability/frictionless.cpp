#include "engine/study/stability/frictionless.h"

#include <utility>

#include "engine/study/playability/changed_networks.h"

namespace tactus {
namespace {

void let_slide(NetworkSpec& network, const std::string&) {
  for (auto& element : network.elements) {
    if (element.type != "friction") continue;
    std::erase_if(element.fields, [](const Field& field) { return field.key == "normal"; });
    element.fields.push_back({"normal", element.at, {0.0, element.at}});
  }
}

}  // namespace

LoadedScene without_friction(LoadedScene loaded) {
  if (loaded.scene) loaded.scene = with_networks_changed(std::move(*loaded.scene), let_slide);
  return loaded;
}

}  // namespace tactus
