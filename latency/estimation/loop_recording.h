#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/index.h"
#include "engine/core/units.h"

namespace tactus {

/// What one stream played and captured: frame n of `played` went out in the same block as frame n of
/// `captured` came in. So a loop of delay D frames brings played[n] at captured[.][n + D].
struct LoopRecording {
  Hertz sample_rate = 48_kHz;
  std::vector<double> played;                 ///< behind the drive guard, full scale = 1
  std::vector<std::vector<double>> captured;  ///< every input channel
};

/// [any] The frames [from, to) of `all`, as far as there are any.
inline std::span<const double> stretch(std::span<const double> all, std::int64_t from, std::int64_t to) {
  const auto size = static_cast<std::int64_t>(all.size());
  from = std::clamp<std::int64_t>(from, 0, size);
  to = std::clamp<std::int64_t>(to, from, size);
  return all.subspan(index(from), index(to - from));
}

/// [any] Sum of a[n] b[n], as far as there are both.
inline double product(std::span<const double> a, std::span<const double> b) {
  double sum = 0.0;
  const auto frames = std::min(a.size(), b.size());
  for (std::size_t n = 0; n < frames; ++n) sum += a[n] * b[n];
  return sum;
}

}  // namespace tactus
