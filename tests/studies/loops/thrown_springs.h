#pragma once

// Thread: [any].

#include <cmath>

namespace tactus::study {

/// A mass on a spring k e + cubic e^3 with a damper, thrown, in explicit steps of T:
///   m (x+ - 2 x + x-) / T^2 = -k x - cubic x^3 - c (x - x-) / T.
struct ThrownSpring {
  double rate = 48000, mass = 1, stiffness = 0, cubic = 0, damping = 0, place = 0, speed = 0;  // SI

  /// From its start, or thrown at 1 m/s as every contact of an explicit network is assumed to be.
  bool grows() const { return grows_from(place, speed) || grows_from(0, 1) || grows_from(place, 1); }

 private:
  bool grows_from(double x, double v) const {
    constexpr int kFrames = 300'000;
    const double t = 1 / rate, first = std::abs(x) + std::abs(v) * t;
    const auto pushed = [&](double at, double q) {
      return t * t / mass * (-stiffness * at - cubic * at * at * at - damping * q / t);
    };
    double q = v * t;
    q -= 0.5 * pushed(x, q);
    double most = first;
    for (int n = 0; n < kFrames; ++n) {
      q += pushed(x, q);
      x += q;
      if (n < kFrames / 10) most = std::max(most, std::abs(x));
      if (!(std::abs(x) < 1e3 * most)) return true;
    }
    return false;
  }
};

}  // namespace tactus::study
