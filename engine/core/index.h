#pragma once

// Thread: [any]
#include <concepts>
#include <cstddef>

namespace tactus {

/// A place in a list: indices are signed everywhere but in the brackets of the standard library.
template <std::signed_integral Signed>
constexpr std::size_t index(Signed i) noexcept {
  return static_cast<std::size_t>(i);
}

}  // namespace tactus
