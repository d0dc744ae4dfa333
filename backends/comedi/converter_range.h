#pragma once

#include <algorithm>
#include <cmath>

namespace tactus {

/// The range of a converter with values from 0 to `most`, and its full scale, the larger of |low| and |high|:
///   volts = low + (high - low) raw / most,   share = volts / full scale.
/// A raw value and its share correspond exactly, to the nearest step. Thread: [any]
struct ConverterRange {
  double low = -1.0, high = 1.0;  ///< [V], low < high
  unsigned most = 65535;          ///< > 0

  double full_scale() const noexcept { return std::max(std::abs(low), std::abs(high)); }
  double step() const noexcept { return (high - low) / most; }
  double share(unsigned raw) const noexcept { return (low + step() * raw) / full_scale(); }
  /// The nearest value; that at the end of the range for what lies beyond it.
  unsigned raw(double share) const noexcept {
    const double steps = (share * full_scale() - low) / step();
    return static_cast<unsigned>(std::lround(std::clamp(steps, 0.0, static_cast<double>(most))));
  }
};

}  // namespace tactus
