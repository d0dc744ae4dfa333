#include "engine/graph/node_type.h"

#include <cassert>

namespace tactus {

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
  const auto* const found = find_named(type->settings, name);
  assert(found != nullptr);
  return settings[index(found - type->settings.data())];
}

int NodeType::input_index(std::string_view port) const {
  const auto* const found = find_named(inputs, port);
  return found == nullptr ? -1 : static_cast<int>(found - inputs.data());
}

}  // namespace tactus
