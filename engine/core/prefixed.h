#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

namespace tactus {

/// [any] A number as people read it: four digits, and with a unit an SI prefix instead of an exponent:
/// "27.37 kN/m". Infinity is "unlimited".
inline std::string prefixed(double value, const std::string& unit) {
  if (std::isinf(value)) return "unlimited";
  constexpr std::array kPrefixes{"p", "n", "u", "m", "", "k", "M", "G"};
  int thousands = 0;
  for (; !unit.empty() && std::abs(value) >= 999.95 && thousands < 3; ++thousands) value /= 1e3;
  for (; !unit.empty() && value != 0 && std::abs(value) < 0.99995 && thousands > -4; --thousands)
    value *= 1e3;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), unit.empty() ? "%.6g" : "%.4g", value);
  if (unit.empty()) return text.data();
  return text.data() + std::string{" "} + kPrefixes[static_cast<std::size_t>(thousands + 4)] + unit;
}

}  // namespace tactus
