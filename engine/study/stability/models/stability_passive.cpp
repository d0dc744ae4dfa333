#include "engine/study/stability/models/stability_passive.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "engine/core/units.h"

namespace tactus {
namespace {

using Complex = std::complex<double>;

/// What comes back to `drive` alone, with what goes through `cut` times `factor`.
Complex alone(Eigen::MatrixXcd returned, int drive, int cut, double factor) {
  returned.col(cut) *= factor;
  return LoopGroup::alone(returned)[static_cast<std::size_t>(drive)];
}

}  // namespace

PassivityTest::PassivityTest(const LoopGroup& group, int drive, std::function<Complex(Complex)> mobility,
                             Hertz rate)
    : drive_(drive), step_(1 / rate.value), mobility_(std::move(mobility)) {
  constexpr int kPoints = 400;
  const double lowest = 2 * kPi * step_;  // 1 Hz
  for (int i = 0; i <= kPoints; ++i) {
    const double radians = lowest * std::pow(kPi / lowest, static_cast<double>(i) / kPoints);
    const auto z = std::polar(1.0, radians);
    points_.push_back({radians, group.returned(z), mobility_(z)});
  }
}

double PassivityTest::device_damping() const {
  double least = std::numeric_limits<double>::infinity();
  for (const double hertz : {1.0, 2.0, 5.0, 10.0}) {
    const double radians = 2 * kPi * hertz * step_;
    // The held force comes half a step late.
    const auto g = mobility_(std::polar(1.0, radians)) * std::polar(1.0, radians / 2);
    least = std::min(least, (1.0 / (Complex{0, 2 * kPi * hertz} * g)).real());
  }
  return least;
}

double PassivityTest::needed(int cut, double factor) const {
  double most = 0;
  for (const auto& point : points_) {
    const auto h = -alone(point.returned, drive_, cut, factor) / point.mobility;
    const double b =
        step_ / 2 / (1 - std::cos(point.radians)) * ((1.0 - std::polar(1.0, -point.radians)) * h).real();
    most = std::max(most, b);
  }
  return most;
}

double PassivityTest::largest_factor(int cut) const {
  const double damping = device_damping();
  double low = 1e-6, high = 1e6;
  if (!(needed(cut, low) <= damping)) return 0;
  if (needed(cut, high) <= damping) return std::numeric_limits<double>::infinity();
  while (high > 1.0001 * low) {
    const double middle = std::sqrt(low * high);
    (needed(cut, middle) <= damping ? low : high) = middle;
  }
  return low;
}

}  // namespace tactus
