#pragma once

#include <algorithm>
#include <cmath>

namespace tactus {

/// [any] db = 20 log10(amplitude) = 10 log10(power). Nothing is -300 dB.
inline double amplitude_from_db(double db) { return std::pow(10.0, db / 20.0); }
inline double power_from_db(double db) { return std::pow(10.0, db / 10.0); }
inline double amplitude_to_db(double amplitude) { return 20.0 * std::log10(std::max(amplitude, 1e-15)); }
inline double power_to_db(double power) { return 10.0 * std::log10(std::max(power, 1e-30)); }

}  // namespace tactus
