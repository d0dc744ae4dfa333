#pragma once

// Thread: [realtime]; constructors and `response` [control].

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "engine/dsp/delays/taps.h"
#include "engine/graph/node.h"

namespace tactus {

/// The range of the times of a delay.
struct TimeRange {
  double low_s, high_s;
};

/// Where the taps of a delay lie: the newest, in frames back, and what each weighs.
template <int Order>
struct DelayAim {
  int newest = 0;
  std::array<double, Order + 1> weights{1.0};
};

/// Times to taps, Order + 1 of them; order 0 is the nearest whole frame, a copy bit for bit.
template <int Order>
class DelayTaps {
 public:
  DelayTaps() = default;
  DelayTaps(TimeRange range, Hertz sample_rate)
      : range_(range),
        sample_rate_(sample_rate),
        // A loop needs a tap in the past; where the delay is never below a frame, no tap is newer.
        newest_possible_(frames_of(range.low_s) >= 1 ? 1 : 0),
        least_(at(range.low_s).newest),
        most_(static_cast<int>(std::ceil(frames_of(range.high_s)))) {}

  TimeRange range() const noexcept { return range_; }
  DelayRange delay() const noexcept { return {least_, std::max(least_, most_)}; }
  /// Frames back of the oldest tap.
  int longest() const noexcept { return most_ + Order; }

  double inside(double seconds) const noexcept {
    return seconds > range_.low_s ? std::min(seconds, range_.high_s) : range_.low_s;
  }

  DelayAim<Order> at(double seconds) const noexcept {
    const double frames = frames_of(seconds);
    const int newest = tactus_delay_newest(frames, Order, Order == 0 ? 0 : newest_possible_);
    if constexpr (Order == 0)
      return {.newest = newest};
    else
      return {.newest = newest, .weights = lagrange_weights<Order>(frames - newest)};
  }

  std::complex<double> response(double seconds, std::complex<double> z) const {
    const auto aim = at(seconds);
    std::complex<double> sum = 0;
    for (std::size_t k = Order + 1; k-- > 0;) sum = sum / z + aim.weights[k];
    return sum * std::pow(z, -aim.newest);
  }

 private:
  double frames_of(double seconds) const noexcept { return tactus_delay_frames(seconds, sample_rate_.value); }

  TimeRange range_{};
  Hertz sample_rate_{};
  int newest_possible_ = 0, least_ = 0, most_ = 0;
};

}  // namespace tactus
