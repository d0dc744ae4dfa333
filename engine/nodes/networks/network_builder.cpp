#include "engine/nodes/networks/network_builder.h"

#include <algorithm>

#include "engine/core/index.h"
#include "engine/graph/plan/fingerprint.h"

namespace tactus {
namespace {

/// Points first: links name them by their index and may precede them in the file. Last, elements that name
/// the force of a link.
int stage_of(const ElementType& type) {
  return type.ends == ElementType::Ends::None ? 0 : type.force_field.empty() ? 1 : 2;
}

double nothing(const Network&, const NetworkState&, const ElementParts&) { return 0.0; }
double energy_of(const Network& network, const NetworkState& state, const ElementParts&) {
  return network.energy(state);
}

}  // namespace

// Of each file, in the order of the reference.
std::vector<ElementType> point_elements();
std::vector<ElementType> space_elements();
std::vector<ElementType> link_elements();
std::vector<ElementType> contact_elements();
std::vector<ElementType> attraction_elements();
std::vector<ElementType> outside_elements();

std::span<const ElementType> network_elements() {
  static const std::vector<ElementType> elements = [] {
    std::vector<ElementType> all;
    for (auto* group : {&point_elements, &space_elements, &link_elements, &contact_elements,
                        &attraction_elements, &outside_elements})
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

int NetworkElement::axes() const {
  if (type->in_space && type->ends == ElementType::Ends::None)
    for (std::size_t i = 0; i < settings.size(); ++i)
      if (type->settings[i].name == "axes") return static_cast<int>(settings[i].number);
  return 1;
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
  leave_out();
}

/// What each signal is, if it never changes.
std::vector<std::optional<double>> NetworkBuilder::constants() const {
  std::vector<std::optional<double>> constants;
  for (const int port : signal_ports) constants.push_back(setup_.inputs[index(port)].constant);
  return constants;
}

PartMarks NetworkBuilder::read_parts() const {
  const bool all = setup_.read.empty() || setup_.read.back();  // the last output is the energy of all
  auto read = marks(elements, all);
  if (all) return read;
  std::size_t output = 0;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto& element = layout_.elements[i];
    const auto& all_quantities = element.type->quantities;
    const auto quantities = index(std::count_if(all_quantities.begin(), all_quantities.end(),
                                                [&](const auto& q) { return element.has(q); }));
    const auto outputs = quantities + (quantities > 0 ? 1 : 0);
    const auto first = setup_.read.begin() + static_cast<std::ptrdiff_t>(output);
    const auto end = first + static_cast<std::ptrdiff_t>(outputs);
    output += outputs;
    if (std::find(first, end, true) == end) continue;
    for_each_part(parts_[i], [&](PartKind kind, int part) {
      for (int a = 0; part >= 0 && a < (kind == PartKind::Point ? element.axes() : 1); ++a)
        read[kind][index(part + a)] = true;
    });
    if (parts_[i].on >= 0) read[PartKind::Point][index(parts_[i].on)] = true;
  }
  return read;
}

void NetworkBuilder::leave_out() {
  const auto needed = needed_parts(elements, read_parts(), acting_parts(elements, constants()));
  find_left_out(needed);
  now_ = keep_parts(elements, needed);
  for_each_list(elements, [&](PartKind kind, const auto&) {
    for (std::size_t i = 0; i < needed[kind].size(); ++i)
      if (needed[kind][i]) original_parts[kind].push_back(static_cast<int>(i));
  });
  std::vector<int> to(signal_ports.size(), -1);
  for_each_input(elements, [&](const NetworkInput& input) {
    if (input.signal >= 0) to[index(input.signal)] = 0;
  });
  for (std::size_t i = 0; i < to.size(); ++i) {
    if (to[i] < 0) continue;
    to[i] = static_cast<int>(original_signals.size());
    signal_ports[original_signals.size()] = signal_ports[i];
    original_signals.push_back(static_cast<int>(i));
  }
  signal_ports.resize(original_signals.size());
  for_each_input(elements, [&](NetworkInput& input) {
    if (input.signal >= 0) input.signal = to[index(input.signal)];
  });
}

/// The same parts as they are called now; -1: left out.
ElementParts NetworkBuilder::kept(const ElementParts& parts) const {
  auto kept = parts;
  for_each_part(kept, [&](PartKind kind, int& part) {
    if (part >= 0) part = now_[kind][index(part)];
  });
  if (kept.on >= 0) kept.on = now_[PartKind::Point][index(kept.on)];
  return kept;
}

bool NetworkBuilder::on_mass(const NetworkElement& element, std::size_t which,
                             const PartMarks& marked) const {
  const int point = end(element, which);
  return point >= 0 && elements.points[index(point)].kind == Point::Kind::Mass &&
         marked[PartKind::Point][index(point)];
}

/// Before anything is: elements of which nothing is `needed`. Fixed points cost nothing.
void NetworkBuilder::find_left_out(const PartMarks& needed) {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto& element = layout_.elements[i];
    bool runs = false, costs = false;
    for_each_part(parts_[i], [&](PartKind kind, int part) {
      if (part < 0) return;
      const bool point = kind == PartKind::Point;
      costs = costs || !point || elements.points[index(part)].kind != Point::Kind::Ground;
      for (int p = 0; p < (point ? element.points() : 1); ++p) runs = runs || needed[kind][index(part + p)];
    });
    if (!costs || runs) continue;
    // On what runs it would have to run, too, if it could act.
    const bool silent = on_mass(element, 0, needed) || on_mass(element, 1, needed);
    left_out_.push_back({element.name, silent ? "its force is always 0" : "reaches no output"});
  }
}

std::uint64_t NetworkBuilder::variant() const {
  Fingerprint print;
  bool all = true;
  for_each_list(elements, [&](PartKind kind, const auto&) {
    for (const int number : now_[kind]) {
      print.add(std::uint64_t{number >= 0});
      all = all && number >= 0;
    }
  });
  return all ? 0 : print.value();
}

std::vector<NetworkReading> NetworkBuilder::readings() const {
  std::vector<NetworkReading> readings;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto& quantities = layout_.elements[i].type->quantities;
    auto parts = kept(parts_[i]);
    if (parts.point < 0) parts.point = parts.on;
    bool whole = (parts.on < 0) == (parts_[i].on < 0);
    for_each_part(parts_[i], [&](PartKind kind, int part) {
      whole = whole && (part < 0 || now_[kind][index(part)] >= 0);
    });
    const auto add = [&](const ElementQuantity& quantity) {
      readings.push_back({whole ? quantity.read : ReadElement{{}, nothing}, parts});
    };
    for (const auto& quantity : quantities)
      if (layout_.elements[i].has(quantity)) add(quantity);
    if (!quantities.empty()) add(quantities.front());
  }
  readings.push_back({{{}, energy_of}, {}});
  return readings;
}

void NetworkBuilder::name_parts(NetworkRecipe& recipe) const {
  recipe.points.resize(elements.points.size());
  recipe.springs.resize(elements.springs.size());
  recipe.contacts.resize(elements.contacts.size());
  const auto name = [](std::vector<std::string>& names, int part, const std::string& element) {
    if (part >= 0) names[index(part)] = element;
  };
  const auto& points = now_[PartKind::Point];
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto& element = layout_.elements[i];
    const auto parts = kept(parts_[i]);
    name(recipe.points, parts.point, element.name);
    name(recipe.springs, parts.spring, element.name);
    name(recipe.contacts, parts.contact, element.name);
    name(recipe.contacts, parts.opposite, element.name);
    const int axes = element.axes();
    for (int p = 0; (element.type->dimensions > 0 || axes > 1) && p < element.points(); ++p) {
      const int mass = p / axes;
      auto text = element.name;
      if (element.rows() > 1) text += "." + std::to_string(1 + mass / element.columns());
      if (element.type->dimensions > 0) text += "." + std::to_string(1 + mass % element.columns());
      if (axes > 1) text += std::string(".") + kAxisNames[index(p % axes)];
      name(recipe.points, points[index(parts_[i].point + p)], text);
    }
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

int NetworkBuilder::axes_at(const NetworkElement& element, std::size_t which) const {
  return layout_.elements[index(element.ends[which])].axes();
}

int NetworkBuilder::add_ground(double at) {
  return append(elements.points, Point{Point::Kind::Ground, 0.0, at, 0.0, {}});
}

}  // namespace tactus
