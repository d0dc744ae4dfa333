#pragma once

#include <cmath>

namespace tactus {

/// z = -h exp(-x^2 / 2 s^2): a valley of depth h. With weight w it feels like a spring of stiffness k = w h /
/// s^2 near its centre, F = -k x exp(-x^2 / 2 s^2); the peak force 0.60653 k s stands at x = +-s.
struct DetentProfile {
  double depth_m = 0;
  double sigma_m = 1;

  double height(double x) const { return -depth_m * bell(x); }
  double slope(double x) const { return depth_m * x / (sigma_m * sigma_m) * bell(x); }
  double curvature(double x) const {
    const double u = x / sigma_m;
    return depth_m / (sigma_m * sigma_m) * (1 - u * u) * bell(x);
  }

 private:
  double bell(double x) const { return std::exp(-0.5 * (x / sigma_m) * (x / sigma_m)); }
};

/// z = h cos(2 pi x / l): the force is (2 pi w h / l) sin(2 pi x / l), the largest stiffness 4 pi^2 w h /
/// l^2.
struct SineProfile {
  double height_m = 0;
  double length_m = 1;

  double height(double x) const { return height_m * std::cos(wave_number() * x); }
  double slope(double x) const { return -height_m * wave_number() * std::sin(wave_number() * x); }
  double curvature(double x) const { return -wave_number() * wave_number() * height(x); }

 private:
  double wave_number() const { return 6.283185307179586 / length_m; }
};

/// F = -w dz/dx: what a mass of weight `w` feels that slides without friction over terrain of height z(x).
/// Berdahl, Steiner, Oldham, NIME 2008, section 6.1.3.
inline double terrain_force(double weight_n, double slope) { return -weight_n * slope; }

}  // namespace tactus
