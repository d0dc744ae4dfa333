#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace tactus {

/// [control] Of an even number the upper of the two middle values; 0 if empty.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// [control] The standard deviation of mostly normal values around 0, insensitive to outliers.
inline double robust_deviation(std::vector<double> values) {
  for (auto& value : values) value = std::abs(value);
  return median(std::move(values)) / 0.6745;
}

}  // namespace tactus
