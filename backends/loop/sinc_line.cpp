#include "backends/loop/sinc_line.h"

#include <array>
#include <bit>
#include <cmath>
#include <numbers>

namespace tactus {
namespace {

constexpr std::size_t kTaps = 2 * SincLine::kReach;
constexpr double kWidth = 9.0;  // standard deviation of the Gaussian [frames]
// Between phases the kernel is taken as straight: wrong by (pi / phases)^2 / 8, which is 1e-6.
constexpr int kPhases = 1024;

using Taps = std::array<double, kTaps>;

/// Weights of the frames -kReach + 1 … kReach around `fraction`.
Taps taps_at(double fraction) {
  Taps taps{};
  for (std::size_t k = 0; k < kTaps; ++k) {
    const double u = static_cast<double>(k) - SincLine::kReach + 1 - fraction;
    const double x = std::numbers::pi * u;
    taps[k] = (u == 0.0 ? 1.0 : std::sin(x) / x) * std::exp(-0.5 * (u / kWidth) * (u / kWidth));
  }
  return taps;
}

const std::vector<Taps>& table() {
  static const std::vector<Taps> phases = [] {
    std::vector<Taps> all;
    for (int phase = 0; phase <= kPhases; ++phase)
      all.push_back(taps_at(static_cast<double>(phase) / kPhases));
    return all;
  }();
  return phases;
}

void set_taps(double fraction, Taps& taps) noexcept {
  const double position = fraction * kPhases;
  const auto phase = static_cast<std::size_t>(position);
  const double share = position - static_cast<double>(phase);
  const Taps& below = table()[phase];
  const Taps& above = table()[phase + 1];
  for (std::size_t k = 0; k < kTaps; ++k) taps[k] = below[k] + share * (above[k] - below[k]);
}

}  // namespace

SincLine::SincLine(std::int64_t back)
    : samples_(std::bit_ceil(static_cast<std::size_t>(back + 2 * kTaps))), mask_(samples_.size() - 1) {
  (void)table();  // made here and not on the real-time path
}

double SincLine::read(std::int64_t frame, double fraction) noexcept {
  if (fraction == 0.0) return (*this)[frame];
  if (fraction != fraction_) {
    fraction_ = fraction;
    set_taps(fraction, taps_);
  }
  std::array<double, 4> sums{};  // one would wait for each addition
  for (std::size_t k = 0; k < kTaps; k += 4)
    for (std::size_t i = 0; i < 4; ++i)
      sums[i] += taps_[k + i] * (*this)[frame + static_cast<std::int64_t>(k + i) - kReach + 1];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

}  // namespace tactus
