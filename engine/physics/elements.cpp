#include "engine/physics/elements.h"

namespace tactus {

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
