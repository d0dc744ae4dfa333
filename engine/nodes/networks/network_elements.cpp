#include "engine/nodes/networks/network_elements.h"

#include "engine/nodes/networks/element_types.h"

namespace tactus {

std::span<const ElementType> network_elements() {
  static const std::vector<ElementType> elements = [] {
    auto all = point_elements();
    for (auto* group : {&link_elements, &contact_elements, &outside_elements})
      for (auto& type : group()) all.push_back(std::move(type));
    return all;
  }();
  return elements;
}

const ElementType* find_element(std::string_view name) {
  for (const auto& element : network_elements())
    if (element.name == name) return &element;
  return nullptr;
}

}  // namespace tactus
