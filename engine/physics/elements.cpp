#include "engine/physics/elements.h"

#include "engine/core/index.h"

namespace tactus {

void renumber(NetworkElements& elements, const std::vector<int>& to) {
  const auto move = [&](int& point) {
    if (point >= 0) point = to[index(point)];
  };
  const auto ends = [&](auto& links) {
    for (auto& link : links) move(link.lower), move(link.upper);
  };
  ends(elements.springs), ends(elements.contacts), ends(elements.frictions), ends(elements.bonds);
  for (auto& force : elements.forces) move(force.on);
  for (auto& port : elements.ports) move(port.on);
  for (auto& coil : elements.coils) move(coil.on), move(coil.against);
}

HandParts attach(NetworkElements& elements, const Hand& hand) {
  const auto last = [](const auto& list) { return static_cast<int>(list.size()) - 1; };
  auto& point = elements.points.emplace_back();
  point.kind = Point::Kind::Motion;
  point.input = {hand.position, hand.bandwidth};
  elements.springs.push_back({hand.on, last(elements.points), hand.stiffness, hand.damping, 0.0});
  elements.forces.push_back({hand.on, {hand.force, hand.bandwidth}});
  return {last(elements.points), last(elements.springs), last(elements.forces)};
}

}  // namespace tactus
