#include "engine/nodes/networks/network_builder.h"

#include <algorithm>

#include "engine/core/index.h"

namespace tactus {
namespace {

/// Points first: links name them by their index and may precede them in the file. Last, elements that name
/// the force of a link.
int stage_of(const ElementType& type) {
  return type.ends == ElementType::Ends::None ? 0 : type.force_field.empty() ? 1 : 2;
}

double energy_of(const Network& network, const NetworkState& state, const ElementParts&) {
  return network.energy(state);
}

}  // namespace

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

NetworkBuilder::NetworkBuilder(const NetworkLayout& layout, const NodeSetup& setup)
    : layout_(layout), setup_(setup) {
  parts_.resize(layout.elements.size());
  for (const int stage : {0, 1, 2})
    for (std::size_t i = 0; i < layout.elements.size(); ++i) {
      const auto& element = layout.elements[i];
      if (stage_of(*element.type) != stage) continue;
      parts_[i].on = end(element, 0);
      element.type->build(*this, element, parts_[i]);
    }
}

std::vector<NetworkReading> NetworkBuilder::readings() const {
  std::vector<NetworkReading> readings;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto& quantities = layout_.elements[i].type->quantities;
    for (const auto& quantity : quantities) readings.push_back({quantity.read, parts_[i]});
    if (!quantities.empty()) readings.push_back({quantities.front().read, parts_[i]});
  }
  readings.push_back({energy_of, {}});
  return readings;
}

void NetworkBuilder::name_parts(NetworkRecipe& recipe) const {
  recipe.points.resize(elements.points.size());
  recipe.springs.resize(elements.springs.size());
  recipe.contacts.resize(elements.contacts.size());
  const auto name = [](std::vector<std::string>& names, int part, const std::string& element) {
    if (part >= 0) names[index(part)] = element;
  };
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto& element = layout_.elements[i];
    name(recipe.points, parts_[i].point, element.name);
    name(recipe.springs, parts_[i].spring, element.name);
    name(recipe.contacts, parts_[i].contact, element.name);
    name(recipe.contacts, parts_[i].opposite, element.name);
    for (int p = 0; element.type->dimensions > 0 && p < element.points(); ++p)
      name(recipe.points, parts_[i].point + p,
           element.name + (element.rows() > 1 ? "." + std::to_string(1 + p / element.columns()) : "") + "." +
               std::to_string(1 + p % element.columns()));
  }
}

int NetworkBuilder::port(const NetworkElement& element, std::string_view field) const {
  const auto& fields = element.type->fields;
  const auto at = std::find_if(fields.begin(), fields.end(), [&](const auto& f) { return f.name == field; });
  return element.ports[index(at - fields.begin())];
}

double NetworkBuilder::number(const NetworkElement& element, std::string_view field) const {
  const int at = port(element, field);
  if (at < 0) return 0.0;
  const auto i = index(at);
  const auto& port = setup_.type->inputs[i];
  const double value = setup_.inputs[i].constant.value_or(port.fallback.value_or(0.0));
  return std::clamp(value, port.low, port.high);
}

NetworkInput NetworkBuilder::signal(const NetworkElement& element, std::string_view field) {
  signal_ports.push_back(port(element, field));
  return {static_cast<int>(signal_ports.size()) - 1, {}};
}

int NetworkBuilder::end(const NetworkElement& element, std::size_t which) const {
  const int of = element.ends[which];
  return of < 0 ? -1 : parts_[index(of)].point + element.within[which];
}

int NetworkBuilder::add_ground(double at) {
  return append(elements.points, Point{Point::Kind::Ground, 0.0, at, 0.0, {}});
}

}  // namespace tactus
