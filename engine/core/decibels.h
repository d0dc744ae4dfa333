#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace tactus {

/// [any] db = 20 log10(amplitude) = 10 log10(power). Nothing is -300 dB.
inline double amplitude_from_db(double db) { return std::pow(10.0, db / 20.0); }
inline double power_from_db(double db) { return std::pow(10.0, db / 10.0); }
inline double amplitude_to_db(double amplitude) { return 20.0 * std::log10(std::max(amplitude, 1e-15)); }
inline double power_to_db(double power) { return 10.0 * std::log10(std::max(power, 1e-30)); }

/// [any] Root mean square and largest absolute value; 0 of no samples.
inline double rms_of(std::span<const double> samples) {
  double squares = 0;
  for (const double x : samples) squares += x * x;
  return samples.empty() ? 0 : std::sqrt(squares / static_cast<double>(samples.size()));
}
inline double peak_of(std::span<const double> samples) {
  double most = 0;
  for (const double x : samples) most = std::max(most, std::abs(x));
  return most;
}

}  // namespace tactus
