#include "engine/nodes/world/world_use.h"

#include <algorithm>
#include <utility>

#include "engine/core/index.h"

namespace tactus {
namespace {

class UseFinder {
 public:
  UseFinder(const WorldLayout& layout, const NodeSetup& setup) : layout_(layout), setup_(setup) {}

  WorldUse run() {
    find_present();
    find_kept();
    return std::move(use_);
  }

 private:
  /// A body that is never there is left out, and a link that is never made.
  void find_present() {
    for (const auto& one : layout_.elements) {
      const int port = one.type->part == WorldPart::Body   ? one.port("present")
                       : one.type->part == WorldPart::Link ? one.port("kind")
                                                           : -1;
      const auto constant = port >= 0 ? setup_.inputs[index(port)].constant : std::nullopt;
      use_.absent.push_back(constant && *constant < 0.5);
    }
  }

  bool read(const WorldElement& one) const {
    if (setup_.read.empty()) return true;
    const auto first = setup_.read.begin() + one.first_output;
    const auto count =
        static_cast<std::ptrdiff_t>(one.type->quantities.size() + !one.type->quantities.empty());
    return std::find(first, first + count, true) != first + count;
  }
  bool world_read() const {
    const auto count = std::ssize(world_quantities());
    return setup_.read.empty() ||
           std::find(setup_.read.end() - count, setup_.read.end(), true) != setup_.read.end();
  }

  void find_kept() {
    const auto count = layout_.elements.size();
    use_.kept.assign(count, false);
    const bool all = world_read();
    for (std::size_t i = 0; i < count; ++i) {
      const auto& one = layout_.elements[i];
      const bool wanted =
          one.type->part == WorldPart::Body ? all || read(one) : read(one) && !one.type->quantities.empty();
      if (wanted) keep(i);
    }
    for (bool grown = true; grown;) {
      grown = false;
      for (std::size_t i = 0; i < count; ++i)
        if (!use_.kept[i] && acts_on_kept(i)) keep(i), grown = true;
    }
  }

  void keep(std::size_t i) {
    const auto& one = layout_.elements[i];
    for (const int end : one.ends)
      if (end >= 0 && use_.absent[index(end)]) return;
    if (use_.absent[i] || use_.kept[i]) return;
    use_.kept[i] = true;
    for (const int end : one.ends)
      if (end >= 0) keep(index(end));
  }

  bool acts_on_kept(std::size_t i) const {
    const auto& one = layout_.elements[i];
    if (use_.absent[i] || (one.ends[0] >= 0 && use_.absent[index(one.ends[0])]) ||
        (one.ends[1] >= 0 && use_.absent[index(one.ends[1])]))
      return false;
    switch (one.type->part) {
      case WorldPart::Body:
        return (one.collides() && (kept_collides() || hits_what_is_watched(one))) ||
               (one.moves() && any_is_held());
      case WorldPart::Joint:
      case WorldPart::Handle:
        if (one.acts_on_any()) return any_kept();
        return use_.kept[index(one.ends[0])] || (one.ends[1] >= 0 && use_.kept[index(one.ends[1])]);
      case WorldPart::Link:
      case WorldPart::Gravity:
        return any_kept();
      case WorldPart::Collision:
        return false;
    }
    return false;
  }
  bool any_kept() const { return std::find(use_.kept.begin(), use_.kept.end(), true) != use_.kept.end(); }
  /// What is kept may act on every body.
  bool any_is_held() const {
    for (std::size_t i = 0; i < use_.kept.size(); ++i)
      if (use_.kept[i] && layout_.elements[i].acts_on_any()) return true;
    return false;
  }
  /// A collision that is kept, of a body against anything.
  bool hits_what_is_watched(const WorldElement& body) const {
    for (std::size_t i = 0; i < use_.kept.size(); ++i) {
      const auto& one = layout_.elements[i];
      if (!use_.kept[i] || one.type->part != WorldPart::Collision || one.ends[1] >= 0) continue;
      if (layout_.elements[index(one.ends[0])].collides() &&
          (body.moves() || layout_.elements[index(one.ends[0])].moves()))
        return true;
    }
    return false;
  }
  /// Something that moves may touch every other body.
  bool kept_collides() const {
    for (std::size_t i = 0; i < use_.kept.size(); ++i)
      if (use_.kept[i] && layout_.elements[i].moves() && layout_.elements[i].collides()) return true;
    return false;
  }

  const WorldLayout& layout_;
  const NodeSetup& setup_;
  WorldUse use_;
};

}  // namespace

WorldUse find_used(const WorldLayout& layout, const NodeSetup& setup) {
  return UseFinder(layout, setup).run();
}

}  // namespace tactus
