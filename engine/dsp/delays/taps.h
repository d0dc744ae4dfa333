#pragma once

// Thread: [realtime].

#include <array>
#include <complex>
#include <cstddef>

#include "engine/dsp/delays/taps_kernel.h"
#include "engine/dsp/simd/lanes.h"

namespace tactus {

/// `tactus_tap_sum`, vectorised: start + sum over k of weight(k) * tap(k).
template <std::size_t Count, class Weight, class Tap>
[[gnu::always_inline]] inline Lanes tap_sum(Weight weight, Tap tap, Lanes start) noexcept {
  Lanes even = fused_multiply_add(weight(0), tap(0), start), odd{};
  if constexpr (Count > 1) odd = weight(1) * tap(1);
  for (std::size_t k = 2; k < Count; ++k) {
    Lanes& chain = k % 2 == 0 ? even : odd;
    chain = fused_multiply_add(weight(k), tap(k), chain);
  }
  return even + odd;
}

/// The same for `frames` consecutive frames: y[n] = start[n] + sum of weight[k] * newest[n - k], with the
/// same bits. `start` may be nullptr for 0. `y` overlaps nothing.
template <std::size_t Count>
void tap_sums(const double* newest, const double* weight, const double* start, double* y,
              int frames) noexcept {
  int n = 0;
  for (; n + Lanes::kCount <= frames; n += Lanes::kCount)
    tap_sum<Count>([&](std::size_t k) { return Lanes::broadcast(weight[k]); },
                   [&](std::size_t k) { return Lanes::load(newest + n - k); },
                   start != nullptr ? Lanes::load(start + n) : Lanes::broadcast(0))
        .store(y + n);
  for (; n < frames; ++n)
    y[n] = tactus_tap_sum(newest + n, weight, static_cast<int>(Count), start != nullptr ? start[n] : 0);
}

/// [any] Of Order + 1 taps, for a time in the range, at any z.
template <int Order>
std::complex<double> delay_response(const tactus_delay& delay, double seconds, std::complex<double> z) {
  double weights[Order + 1];
  const int newest = tactus_delay_aim(&delay, Order, seconds, weights);
  std::complex<double> sum = 0;
  for (std::size_t k = Order + 1; k-- > 0;) sum = sum / z + weights[k];
  return sum * std::pow(z, -newest);
}

/// A place in the past of each of eight interleaved signals.
using LanePlaces = std::array<const double*, Lanes::kCount>;

/// The last Count samples of eight interleaved signals, newest first, shifted on frame by frame, so that each
/// frame fetches one sample a lane whatever the number of taps.
template <std::size_t Count>
class VectorTaps {
 public:
  /// Its oldest taps for the first frame lie at `oldest`; the newest is fetched by `next`.
  explicit VectorTaps(const LanePlaces& oldest) noexcept {
    for (std::size_t k = Count; k-- > 1;) at_[k - 1] = Lanes::gather(oldest.data(), offset(Count - 1 - k));
  }

  /// Tap k lies at oldest + Count - 1 - k of frame 0.
  void next(const LanePlaces& oldest, int frame) noexcept {
    for (std::size_t k = Count; k-- > 1;) at_[k] = at_[k - 1];
    at_[0] = Lanes::gather(oldest.data(), offset(Count - 1 + static_cast<std::size_t>(frame)));
  }

  Lanes newest() const noexcept { return at_[0]; }
  Lanes sum(const std::array<Lanes, Count>& weight, Lanes start) const noexcept {
    return tap_sum<Count>([&](std::size_t k) { return weight[k]; }, [&](std::size_t k) { return at_[k]; },
                          start);
  }

 private:
  static std::ptrdiff_t offset(std::size_t frame) noexcept {
    return static_cast<std::ptrdiff_t>(frame) * Lanes::kCount;
  }

  std::array<Lanes, Count> at_;
};

}  // namespace tactus
