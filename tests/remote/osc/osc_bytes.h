#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tactus::test {

/// A literal with zeros in it.
template <std::size_t N>
std::string bytes(const char (&text)[N]) {
  return {text, N - 1};
}

/// A bundle as the specification has its bytes; `tag`: the eight of its time.
inline std::string bundle_of(const std::string& tag, const std::vector<std::string>& elements) {
  std::string bundle = bytes("#bundle\0") + tag;
  for (const auto& element : elements) {
    for (int shift = 24; shift >= 0; shift -= 8) bundle += static_cast<char>(element.size() >> shift);
    bundle += element;
  }
  return bundle;
}

}  // namespace tactus::test
