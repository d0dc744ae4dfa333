#pragma once

// Thread: [control].

#include <complex>
#include <optional>

#include "engine/study/stability/stability_loops.h"
#include "engine/study/stability/stability_world.h"

namespace tactus {

/// What a force law does to a held device that is sampled and held (Colgate & Schenkel, J. Robotic Systems
/// 14(1), 1997): it takes out no more energy than the device loses by itself, whoever holds it, while
///     b > (T/2) / (1 - cos wT) Re{(1 - e^-jwT) H(e^jwT)}    for 0 < w <= pi/T,
/// with H the force on the device against its position, delays included. Here H = -L / G: L what comes back
/// to the cut at the drive, G from a force on the device to its position.
class PassivityTest {
 public:
  /// `drive`: the one cut that the force goes through.
  PassivityTest(const LoopGroup& group, int drive,
                std::function<std::complex<double>(std::complex<double>)> mobility, Hertz rate);

  /// b of the device: Re{1 / (jw G)} near 0 Hz, half a step of hold taken off [N s/m].
  double device_damping() const;
  /// The largest factor on what goes through `cut` for which the device loses enough; 0: none.
  double largest_factor(int cut) const;

 private:
  double needed(int cut, double factor) const;

  struct Point {
    double radians;
    Eigen::MatrixXcd returned;
    std::complex<double> mobility;
  };
  int drive_;
  double step_;
  std::function<std::complex<double>(std::complex<double>)> mobility_;
  std::vector<Point> points_;
};

}  // namespace tactus
