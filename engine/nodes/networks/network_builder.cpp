#include "engine/nodes/networks/network_builder.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace tactus {
namespace {

template <class List, class Part>
int append(List& list, Part part) {
  list.push_back(std::move(part));
  return static_cast<int>(list.size()) - 1;
}

}  // namespace

NetworkBuilder::NetworkBuilder(const NetworkLayout& layout, const NodeSetup& setup)
    : layout_(layout), setup_(setup) {
  parts_.resize(layout.elements.size());
  // Points first: links name them by their index, and may stand before them in the file. Frictions last: they
  // name links.
  const auto stage = [](const Element& e) {
    return e.type->ends == ElementType::Ends::None ? 0 : e.type->name == "friction" ? 2 : 1;
  };
  for (const int now : {0, 1, 2})
    for (std::size_t i = 0; i < layout.elements.size(); ++i)
      if (const auto& element = layout.elements[i]; stage(element) == now)
        now == 0 ? add_points(element, parts_[i]) : add_link(element, parts_[i]);
}

std::vector<NetworkReading> NetworkBuilder::readings() const {
  std::vector<NetworkReading> readings;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto& element = layout_.elements[i];
    const auto& quantities = element.type->quantities;
    for (const auto& quantity : quantities) readings.push_back(reading(quantity.kind, element, parts_[i]));
    if (!quantities.empty()) readings.push_back(reading(quantities.front().kind, element, parts_[i]));
  }
  readings.push_back({ElementQuantity::Kind::Energy});
  return readings;
}

void NetworkBuilder::name_parts(NetworkRecipe& recipe) const {
  recipe.points.resize(elements.points.size());
  recipe.springs.resize(elements.springs.size());
  recipe.contacts.resize(elements.contacts.size());
  const auto name = [](std::vector<std::string>& names, int part, const std::string& element) {
    if (part >= 0) names[static_cast<std::size_t>(part)] = element;
  };
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const auto& element = layout_.elements[i];
    name(recipe.points, parts_[i].point, element.name);
    name(recipe.springs, parts_[i].spring, element.name);
    name(recipe.contacts, parts_[i].contact, element.name);
    name(recipe.contacts, parts_[i].opposite, element.name);
    for (int p = 0; element.type->many && p < element.points(); ++p)
      name(recipe.points, parts_[i].point + p,
           element.name + (element.rows() > 1 ? "." + std::to_string(1 + p / element.columns()) : "") + "." +
               std::to_string(1 + p % element.columns()));
  }
}

NetworkReading NetworkBuilder::reading(ElementQuantity::Kind kind, const Element& element,
                                       const Parts& parts) const {
  using Kind = ElementQuantity::Kind;
  switch (kind) {
    case Kind::Position:
    case Kind::Velocity:
      // Of a port and a probe: of the mass that they are on.
      return {kind, parts.point >= 0 ? parts.point : end(element, 0)};
    case Kind::Extension:
      return {kind, parts.spring};
    case Kind::SpringForce:
      return {kind, parts.spring, parts.force, parts.contact, parts.opposite};
    case Kind::Indentation:
    case Kind::ContactForce:
      return {.kind = kind, .part = parts.contact, .minus = parts.opposite};
    case Kind::AppliedForce:
      return {kind, parts.force};
    case Kind::Current:
    case Kind::CoilForce:
      return {kind, parts.coil};
    case Kind::FrictionForce:
    case Kind::FrictionVelocity:
      return {kind, parts.friction};
    case Kind::PluckForce:
      return {kind, parts.pluck};
    case Kind::Wave:
    case Kind::PortForce:
      return {kind, parts.port};
    case Kind::Energy:
      break;
  }
  return {kind};
}

int NetworkBuilder::port(const Element& element, std::string_view field) const {
  const auto& fields = element.type->fields;
  const auto at = std::find_if(fields.begin(), fields.end(), [&](const auto& f) { return f.name == field; });
  return element.ports[static_cast<std::size_t>(at - fields.begin())];
}

/// 0 for an optional field that is not there.
double NetworkBuilder::number(const Element& element, std::string_view field) const {
  const int at = port(element, field);
  if (at < 0) return 0.0;
  const auto i = static_cast<std::size_t>(at);
  const auto& port = setup_.type->inputs[i];
  const double value = setup_.inputs[i].constant.value_or(port.fallback.value_or(0.0));
  return std::clamp(value, port.low, port.high);
}

Drive NetworkBuilder::signal(const Element& element, std::string_view field) {
  signal_ports.push_back(port(element, field));
  return {static_cast<int>(signal_ports.size()) - 1, {}};
}

int NetworkBuilder::end(const Element& element, std::size_t which) const {
  const int of = element.ends[which];
  return of < 0 ? -1 : parts_[static_cast<std::size_t>(of)].point + element.within[which];
}

int NetworkBuilder::ground(double at) {
  return append(elements.points, Point{Point::Kind::Ground, 0.0, at, 0.0, {}});
}

void NetworkBuilder::add_points(const Element& e, Parts& parts) {
  const auto& type = e.type->name;
  if (type == "oscillator") return add_oscillator(e, parts);
  if (e.type->many) return add_many(e, parts);
  if (type == "ground")
    parts.point = ground(number(e, "at"));
  else if (type == "motion")
    parts.point = append(elements.points, Point{Point::Kind::Motion, 0.0, 0.0, 0.0, signal(e, "position")});
  else
    parts.point =
        append(elements.points,
               Point{Point::Kind::Mass, number(e, "mass"), number(e, "at"), number(e, "velocity"), {}});
}

void NetworkBuilder::add_oscillator(const Element& e, Parts& parts) {
  const double mass = number(e, "mass");
  const double turn = 2.0 * std::numbers::pi * number(e, "frequency");
  const double stiffness = port(e, "frequency") >= 0 ? mass * turn * turn : number(e, "stiffness");
  const double damping = port(e, "damping_ratio") >= 0
                             ? 2.0 * number(e, "damping_ratio") * std::sqrt(mass * stiffness)
                             : number(e, "damping");
  parts.point =
      append(elements.points, Point{Point::Kind::Mass, mass, number(e, "at"), number(e, "velocity"), {}});
  parts.spring =
      append(elements.springs, Spring{ground(number(e, "rest")), parts.point, stiffness, damping, 0.0});
}

/// A chain, a ring or a grid: masses row by row, springs to the right and up, and to the ground.
void NetworkBuilder::add_many(const Element& e, Parts& parts) {
  const int rows = e.rows(), columns = e.columns();
  const bool ring = e.type->name == "ring", grid = e.type->name == "grid", fixed = e.chosen("ends", "fixed");
  const double stiffness = number(e, "stiffness"), damping = number(e, "damping");
  const double own = number(e, "ground_stiffness"), own_damping = number(e, "ground_damping");
  const double at = number(e, "at"), mass = number(e, "mass");
  parts.point = static_cast<int>(elements.points.size());
  for (int i = 0; i < rows * columns; ++i) elements.points.push_back({Point::Kind::Mass, mass, at, 0.0, {}});
  const int floor = ground(at);
  const auto join = [&](int one, int other) {
    elements.springs.push_back({one, other, stiffness, damping, 0.0});
  };
  const auto hold = [&](int point, int sides) {
    const double k = sides * stiffness + own, z = sides * damping + own_damping;
    if (k != 0.0 || z != 0.0) elements.springs.push_back({floor, point, k, z, 0.0});
  };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int here = parts.point + row * columns + column;
      if (column + 1 < columns) join(here, here + 1);
      if (row + 1 < rows) join(here, here + columns);
      const int border =
          (column == 0) + (column + 1 == columns) + (grid ? (row == 0) + (row + 1 == rows) : 0);
      hold(here, fixed ? border : 0);
    }
  }
  if (ring && columns > 2) join(parts.point + columns - 1, parts.point);
}

void NetworkBuilder::add_link(const Element& e, Parts& parts) {
  const auto& type = e.type->name;
  const int first = end(e, 0), second = end(e, 1);
  if (type == "spring")
    add_spring(e, parts);
  else if (type == "damper")
    parts.spring = append(elements.springs, Spring{first, second, 0.0, number(e, "damping"), 0.0});
  else if (type == "contact")
    add_contact(e, parts);
  else if (type == "friction")
    add_friction(e, parts);
  else if (type == "pluck")
    parts.pluck = append(elements.plucks, Pluck{first, second, number(e, "stiffness"), number(e, "damping"),
                                                number(e, "limit")});
  else if (type == "force")
    parts.force = append(elements.forces, AppliedForce{first, signal(e, "force")});
  else if (type == "hand")
    add_hand(e, parts);
  else if (type == "port")
    parts.port = append(elements.ports, WavePort{first, number(e, "impedance"), signal(e, "wave")});
  else if (type == "coil")
    parts.coil =
        append(elements.coils, Coil{first, second, number(e, "force_factor"), number(e, "resistance"),
                                    number(e, "inductance"), signal(e, "voltage")});
}

/// A cubic spring is a pair of contacts without a gap between them: their power law is the third.
void NetworkBuilder::add_spring(const Element& e, Parts& parts) {
  const int first = end(e, 0), second = end(e, 1);
  const double cubic = number(e, "cubic"), rest = number(e, "rest");
  parts.spring =
      append(elements.springs, Spring{first, second, number(e, "stiffness"), number(e, "damping"), rest});
  if (cubic == 0.0) return;
  const auto side = [&](int lower, int upper, double offset) {
    return append(elements.contacts, Contact{.lower = lower,
                                             .upper = upper,
                                             .stiffness = cubic,
                                             .exponent = 3.0,
                                             .restitution = {},
                                             .offset = offset});
  };
  parts.contact = side(second, first, -rest);
  parts.opposite = side(first, second, rest);
}

void NetworkBuilder::add_contact(const Element& e, Parts& parts) {
  Contact contact{end(e, 0),         end(e, 1), number(e, "stiffness"), number(e, "exponent"),
                  number(e, "loss"), {},        number(e, "offset")};
  if (port(e, "restitution") >= 0) contact.restitution = number(e, "restitution");
  if (e.settings[0].number == 2.0) {
    auto opposite = contact;
    std::swap(opposite.lower, opposite.upper);
    opposite.offset = -contact.offset - number(e, "clearance");
    contact.offset -= number(e, "clearance");
    parts.opposite = append(elements.contacts, opposite);
  }
  parts.contact = append(elements.contacts, contact);
}

void NetworkBuilder::add_friction(const Element& e, Parts& parts) {
  Friction friction{
      .lower = end(e, 0), .upper = end(e, 1), .law = {}, .viscous = number(e, "viscous"), .normal = {}};
  if (e.chosen("law", "rosin")) {
    friction.law = kRosin;
  } else {
    friction.law.kinetic = number(e, "kinetic");
    const double drop = port(e, "holding") >= 0 ? number(e, "holding") - friction.law.kinetic : 0.0;
    friction.law.drops[0] = {std::max(0.0, drop), number(e, "speed")};
  }
  if (e.normal_link >= 0) {
    const auto& link = parts_[static_cast<std::size_t>(e.normal_link)];
    friction.normal_spring = link.spring;
    if (link.spring < 0) friction.normal_contact = link.contact;
  } else {
    friction.normal = signal(e, "normal");
  }
  parts.friction = append(elements.frictions, friction);
}

void NetworkBuilder::add_hand(const Element& e, Parts& parts) {
  const int place = signal(e, "position").signal, push = signal(e, "force").signal;
  const auto made = attach(elements, Hand{end(e, 0), number(e, "stiffness"), number(e, "damping"),
                                          Hertz{number(e, "bandwidth")}, place, push});
  parts.point = made.point;
  parts.spring = made.spring;
  parts.force = made.force;
}

}  // namespace tactus
