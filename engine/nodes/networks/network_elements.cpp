#include "engine/nodes/networks/network_elements.h"

#include <algorithm>

#include "engine/core/index.h"

namespace tactus {

// Of each file, in the order of the reference.
std::vector<ElementType> point_elements();
std::vector<ElementType> link_elements();
std::vector<ElementType> contact_elements();
std::vector<ElementType> attraction_elements();
std::vector<ElementType> outside_elements();

std::span<const ElementType> network_elements() {
  static const std::vector<ElementType> elements = [] {
    std::vector<ElementType> all;
    for (auto* group :
         {&point_elements, &link_elements, &contact_elements, &attraction_elements, &outside_elements})
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

int NetworkElement::rows() const { return type->dimensions > 1 ? static_cast<int>(settings[0].number) : 1; }

int NetworkElement::columns() const {
  const auto last = index(std::max(0, type->dimensions - 1));
  return type->dimensions > 0 ? static_cast<int>(settings[last].number) : 1;
}

bool NetworkElement::chosen(std::string_view setting, std::string_view word) const {
  for (std::size_t i = 0; i < settings.size(); ++i)
    if (type->settings[i].name == setting) return settings[i].text == word;
  return false;
}

}  // namespace tactus
