#include "engine/graph/plan/schedule.h"

namespace tactus {

void Arena::resize(std::size_t doubles) {
  constexpr std::size_t kLine = 64 / sizeof(double);
  storage_ = std::make_unique<double[]>(doubles + kLine);
  const auto address = reinterpret_cast<std::uintptr_t>(storage_.get());
  base_ = storage_.get() + (64 - address % 64) % 64 / sizeof(double);
  size_ = doubles;
}

int Schedule::control_index(std::string_view control) const {
  for (std::size_t i = 0; i < controls.size(); ++i)
    if (controls[i].control.name == control) return static_cast<int>(i);
  return -1;
}

}  // namespace tactus
