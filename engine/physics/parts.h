#pragma once

// Thread: [control]
#include <array>
#include <optional>
#include <vector>

#include "engine/core/index.h"
#include "engine/physics/elements.h"

namespace tactus {

/// The lists of `NetworkElements`.
enum class PartKind { Point, Spring, Contact, Force, Coil, Friction, Bond, Port };
template <class T>
class PerKind {
 public:
  T& operator[](PartKind kind) { return of_[index(static_cast<int>(kind))]; }
  const T& operator[](PartKind kind) const { return of_[index(static_cast<int>(kind))]; }
  bool operator==(const PerKind&) const = default;

 private:
  std::array<T, 8> of_;
};

/// Whether each part …
using PartMarks = PerKind<std::vector<bool>>;
/// The number of each part in other elements; -1: it is not there.
using PartNumbers = PerKind<std::vector<int>>;

/// [any] Calls `each(kind, list)` for every list of the elements.
template <class Elements, class Each>
void for_each_list(Elements& elements, Each each) {
  each(PartKind::Point, elements.points);
  each(PartKind::Spring, elements.springs);
  each(PartKind::Contact, elements.contacts);
  each(PartKind::Force, elements.forces);
  each(PartKind::Coil, elements.coils);
  each(PartKind::Friction, elements.frictions);
  each(PartKind::Bond, elements.bonds);
  each(PartKind::Port, elements.ports);
}

/// As many marks as there are parts.
PartMarks marks(const NetworkElements& elements, bool mark);

/// The links that can exert a force: not a spring without stiffness and damping, a coil without a force
/// factor, a force that is always 0, a friction that is never pressed. `constants`: of each input of the
/// network, its value where it never changes. Points are not marked.
PartMarks acting_parts(const NetworkElements& elements, const std::vector<std::optional<double>>& constants);

/// The parts on which the motion and the forces of the parts in `read` depend: from mass to mass along
/// everything that is `acting`, which fixed and driven points end, and from a friction to what presses it.
PartMarks needed_parts(const NetworkElements& elements, const PartMarks& read, const PartMarks& acting);

/// Removes the parts that are not marked; a marked one must not name one that is not. Returns where each part
/// is now.
PartNumbers keep_parts(NetworkElements& elements, const PartMarks& kept);

/// Points are called `to[point]` from now on, by all links.
void renumber_points(NetworkElements& elements, const std::vector<int>& to);

/// Calls `each(input)` for every input of the elements.
template <class Each>
void for_each_input(NetworkElements& elements, Each each) {
  for (auto& point : elements.points)
    if (point.kind == Point::Kind::Motion) each(point.input);
  for (auto& force : elements.forces) each(force.input);
  for (auto& coil : elements.coils) each(coil.voltage);
  for (auto& friction : elements.frictions) each(friction.normal);
  for (auto& port : elements.ports) each(port.wave);
}

}  // namespace tactus
