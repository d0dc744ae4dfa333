#include "engine/physics/parts.h"

#include <algorithm>
#include <utility>

namespace tactus {
namespace {

using Ends = std::array<int, 2 * kMostAxes>;

// The points that a part names; -1: none.
template <class Link>
Ends ends_of(const Link& link) {
  Ends ends = {link.lower, link.upper, -1, -1, -1, -1};
  if constexpr (requires { link.axes; })
    for (int a = 1; a < link.axes; ++a)
      ends[index(2 * a)] = link.lower + a, ends[index(2 * a + 1)] = link.upper + a;
  return ends;
}
Ends ends_of(const AppliedForce& force) { return {force.on, -1, -1, -1, -1, -1}; }
Ends ends_of(const WavePort& port) { return {port.on, -1, -1, -1, -1, -1}; }
Ends ends_of(const Coil& coil) { return {coil.on, coil.against, -1, -1, -1, -1}; }

using Constants = std::vector<std::optional<double>>;

std::optional<double> constant(const NetworkInput& input, const Constants& constants) {
  return input.signal < 0 ? 0.0 : constants[index(input.signal)];
}

bool acts(const Point&, const Constants&) { return false; }
template <class Link>
bool acts(const Link&, const Constants&) {
  return true;
}
bool acts(const Spring& spring, const Constants&) { return spring.stiffness != 0.0 || spring.damping != 0.0; }
bool acts(const Coil& coil, const Constants&) { return coil.force_factor != 0.0; }
bool acts(const AppliedForce& force, const Constants& constants) {
  return constant(force.input, constants) != 0.0;
}
bool acts(const Friction& friction, const Constants& constants) {
  if (friction.viscous != 0.0) return true;
  const bool pressed = friction.normal_contact >= 0 || friction.normal_spring >= 0;
  // Pulling apart counts as 0.
  return pressed || constant(friction.normal, constants).value_or(1.0) > 0.0;
}

class Search {
 public:
  Search(const NetworkElements& elements, const PartMarks& read, const PartMarks& acting)
      : elements_(elements), needed_(marks(elements, false)), on_(elements.points.size()) {
    for_each_list(elements, [&](PartKind kind, const auto& list) {
      for (std::size_t i = 0; i < list.size(); ++i) {
        if (read[kind][i]) need(kind, i);
        if (acting[kind][i]) attach(kind, i, list[i]);
      }
    });
  }

  PartMarks run() {
    while (!work_.empty()) {
      const auto [kind, number] = work_.back();
      work_.pop_back();
      if (kind == PartKind::Point)
        follow_point(number);
      else
        for_each_list(elements_, [&, kind = kind, number = number](PartKind of, const auto& list) {
          if (of == kind) follow_part(list[number]);
        });
    }
    return std::move(needed_);
  }

 private:
  void need(PartKind kind, std::size_t number) {
    if (needed_[kind][number]) return;
    needed_[kind][number] = true;
    work_.push_back({kind, number});
  }

  void attach(PartKind, std::size_t, const Point&) {}
  template <class Part>
  void attach(PartKind kind, std::size_t number, const Part& part) {
    for (const int end : ends_of(part))
      if (end >= 0) on_[index(end)].push_back({kind, number});
  }

  /// Of masses; other points go their way whatever is on them.
  void follow_point(std::size_t point) {
    if (elements_.points[point].kind != Point::Kind::Mass) return;
    for (const auto& [kind, number] : on_[point]) need(kind, number);
  }

  void follow_part(const Point&) {}
  template <class Part>
  void follow_part(const Part& part) {
    for (const int end : ends_of(part))
      if (end >= 0) need(PartKind::Point, index(end));
    if constexpr (std::is_same_v<Part, Friction>) {
      if (part.normal_contact >= 0) need(PartKind::Contact, index(part.normal_contact));
      if (part.normal_spring >= 0) need(PartKind::Spring, index(part.normal_spring));
    }
  }

  struct Part {
    PartKind kind;
    std::size_t number;
  };
  const NetworkElements& elements_;
  PartMarks needed_;
  std::vector<std::vector<Part>> on_;  ///< what acts on each point
  std::vector<Part> work_;             ///< is needed, but what it needs is not marked yet
};

}  // namespace

PartMarks marks(const NetworkElements& elements, bool mark) {
  PartMarks all;
  for_each_list(elements, [&](PartKind kind, const auto& list) { all[kind].assign(list.size(), mark); });
  return all;
}

PartMarks acting_parts(const NetworkElements& elements, const Constants& constants) {
  PartMarks acting;
  for_each_list(elements, [&](PartKind kind, const auto& list) {
    for (const auto& part : list) acting[kind].push_back(acts(part, constants));
  });
  return acting;
}

PartMarks needed_parts(const NetworkElements& elements, const PartMarks& read, const PartMarks& acting) {
  return Search{elements, read, acting}.run();
}

PartNumbers keep_parts(NetworkElements& elements, const PartMarks& kept) {
  PartNumbers now;
  for_each_list(elements, [&](PartKind kind, auto& list) {
    std::size_t next = 0;
    for (std::size_t i = 0; i < list.size(); ++i) {
      now[kind].push_back(kept[kind][i] ? static_cast<int>(next) : -1);
      if (!kept[kind][i]) continue;
      if (next != i) list[next] = std::move(list[i]);
      ++next;
    }
    list.erase(list.begin() + static_cast<std::ptrdiff_t>(next), list.end());
  });
  renumber_points(elements, now[PartKind::Point]);
  for (auto& friction : elements.frictions) {
    if (friction.normal_contact >= 0)
      friction.normal_contact = now[PartKind::Contact][index(friction.normal_contact)];
    if (friction.normal_spring >= 0)
      friction.normal_spring = now[PartKind::Spring][index(friction.normal_spring)];
  }
  return now;
}

void renumber_points(NetworkElements& elements, const std::vector<int>& to) {
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

}  // namespace tactus
