#include "engine/graph/node_type.h"

#include <cassert>

namespace tactus {
namespace {

template <class Items>
int index_of(const Items& items, std::string_view name) {
  for (std::size_t i = 0; i < items.size(); ++i)
    if (items[i].name == name) return static_cast<int>(i);
  return -1;
}

}  // namespace

Status MemoryBudget::take(std::size_t numbers) {
  if (numbers > left_ / sizeof(double))
    return fail(Errc::OutOfRange, {},
                "the graph would need more than " + std::to_string(bytes_ >> 20) + " MB",
                "use shorter delays and recordings, or fewer voices");
  left_ -= numbers * sizeof(double);
  return {};
}

Status NodeSetup::take_memory(std::size_t numbers) const {
  return memory != nullptr ? memory->take(numbers) : Status{};
}

const InputInfo& NodeSetup::input(std::string_view name) const {
  const int i = type->input_index(name);
  assert(i >= 0);
  const auto& info = inputs[index(i)];
  info.asked = true;
  return info;
}

const SettingValue& NodeSetup::setting(std::string_view name) const {
  const int i = index_of(type->settings, name);
  assert(i >= 0);
  return settings[index(i)];
}

int NodeType::input_index(std::string_view port) const { return index_of(inputs, port); }

}  // namespace tactus
