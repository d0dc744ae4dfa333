#pragma once

namespace tactus {

/// Cubic through `b` (at = 0) and `c` (at = 1) with the slopes (c - a) / 2 and (d - b) / 2; continuous in
/// value and slope from one interval to the next, and exact for parabolas. Catmull & Rom, "A class of local
/// interpolating splines", 1974.
inline double catmull_rom(double a, double b, double c, double d, double at) {
  const double slope_b = 0.5 * (c - a);
  const double slope_c = 0.5 * (d - b);
  const double cubic = slope_b + slope_c - 2.0 * (c - b);
  const double square = (c - b) - slope_b - cubic;
  return ((cubic * at + square) * at + slope_b) * at + b;
}

}  // namespace tactus
