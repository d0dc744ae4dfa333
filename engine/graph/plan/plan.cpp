#include "engine/graph/plan/plan.h"

#include <algorithm>

namespace tactus {

void Arena::resize(std::size_t doubles) {
  constexpr std::size_t kLine = 64 / sizeof(double);
  storage_ = std::make_unique<double[]>(doubles + kLine);
  const auto address = reinterpret_cast<std::uintptr_t>(storage_.get());
  base_ = storage_.get() + (64 - address % 64) % 64 / sizeof(double);
  size_ = doubles;
}

std::optional<double> Plan::constant(const Wire& wire) const {
  const auto& vertex = vertex_of(wire);
  if (vertex.kind != Vertex::Kind::Constant) return std::nullopt;
  if (vertex.width == 1) return vertex.value;
  const auto& values = vertex.values;
  const bool same = std::count(values.begin(), values.end(), values.front()) == std::ssize(values);
  return same ? std::optional{values.front()} : std::nullopt;
}

int Plan::control_index(std::string_view control) const {
  for (std::size_t i = 0; i < controls.size(); ++i)
    if (controls[i].control.name == control) return static_cast<int>(i);
  return -1;
}

}  // namespace tactus
