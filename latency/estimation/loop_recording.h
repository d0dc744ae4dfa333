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

/// How an actuator, what it moves, and the sensor answer together: an impulse response from the
/// sample that leaves the card to the sample that the card captures, with the card's own delay taken off.
struct PathProfile {
  Hertz sample_rate = 48_kHz;
  std::vector<double> taps;  ///< captured[n] = sum of taps[k] played[n - k]
  Hertz low, high;           ///< between these it is known
};

/// [any] The frames [from, to) of `all`, as far as there are any.
inline std::span<const double> part_of(std::span<const double> all, std::int64_t from, std::int64_t to) {
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

/// [control] Of the numbers 0 … count - 1: where runs begin for which `broken` holds, of at most `longest`.
template <class Broken>
std::vector<std::int64_t> short_runs(std::int64_t count, std::int64_t longest, const Broken& broken) {
  std::vector<std::int64_t> begins;
  std::int64_t run = 0;
  for (std::int64_t n = 0; n <= count; ++n) {
    const bool here = n < count && broken(n);
    if (!here && run > 0 && run <= longest) begins.push_back(n - run);
    run = here ? run + 1 : 0;
  }
  return begins;
}

}  // namespace tactus
