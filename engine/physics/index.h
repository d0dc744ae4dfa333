#pragma once

#include <cstddef>

namespace tactus {

/// [any] A place in a list, which the elements of a network keep as an int.
constexpr std::size_t index(int i) noexcept { return static_cast<std::size_t>(i); }

/// [any]
constexpr double square(double x) noexcept { return x * x; }

}  // namespace tactus
