#pragma once

// Thread: [control]

#include <algorithm>
#include <string>
#include <vector>

namespace tactus {

/// The first item whose `name` this is, or nullptr.
template <class Items>
auto* find_named(Items& items, const auto& name) {
  const auto found =
      std::find_if(items.begin(), items.end(), [&](const auto& item) { return item.name == name; });
  return found == items.end() ? nullptr : &*found;
}

/// The names of all items, in order.
template <class Items>
std::vector<std::string> names_of(const Items& items) {
  std::vector<std::string> names;
  for (const auto& item : items) names.push_back(item.name);
  return names;
}

}  // namespace tactus
