#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace tactus {

/// [control] The value below which `share` of them lie, from 0 to less than 1; 0 if empty.
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// [control] Of an even number the upper of the two middle values; 0 if empty.
inline double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

/// [control] The standard deviation of mostly normal values around 0, insensitive to outliers.
inline double robust_deviation(std::vector<double> values) {
  for (auto& value : values) value = std::abs(value);
  return median(std::move(values)) / 0.6745;
}

}  // namespace tactus
