#pragma once

#include <array>
#include <cstddef>

#include "engine/dsp/delays/delay_line.h"

namespace tactus {

/// The last frames of eight signals side by side, each read at its own distance.
class WideDelayLine {
 public:
  using Places = std::array<const double*, Lanes::kCount>;

  /// [control] Remembers at least `longest` frames, readable in a row over `longest_run` of them.
  WideDelayLine(int longest, int longest_run) : line_(longest * Lanes::kCount, longest_run * Lanes::kCount) {}

  /// [realtime]
  void reset() noexcept { line_.reset(); }
  /// [realtime] See DelayLine::adopt.
  void adopt(WideDelayLine& other) noexcept { line_.adopt(other.line_); }
  /// [realtime] At most `longest_run` interleaved frames.
  void write(const double* x, int frames) noexcept { line_.write(x, frames * Lanes::kCount); }

  /// [realtime] Points at what was written into `lane` `back` frames ago (1: the last one); later ones follow
  /// every Lanes::kCount.
  const double* behind(int lane, int back) const noexcept {
    return line_.behind(back * Lanes::kCount) + lane;
  }

 private:
  DelayLine line_;
};

/// The last Count samples of each lane, newest first, shifted on frame by frame, so that each frame fetches
/// one sample a lane whatever the number of taps.
template <std::size_t Count>
class WideTaps {
 public:
  /// Its oldest taps for the first frame lie at `oldest`; the newest is fetched by `next`.
  explicit WideTaps(const WideDelayLine::Places& oldest) noexcept {
    for (std::size_t k = Count; k-- > 1;) at_[k - 1] = Lanes::gather(oldest.data(), place(Count - 1 - k));
  }

  /// Tap k lies at oldest + Count - 1 - k of frame 0.
  void next(const WideDelayLine::Places& oldest, int frame) noexcept {
    for (std::size_t k = Count; k-- > 1;) at_[k] = at_[k - 1];
    at_[0] = Lanes::gather(oldest.data(), place(Count - 1 + static_cast<std::size_t>(frame)));
  }

  Lanes newest() const noexcept { return at_[0]; }

  /// As tap_sum.
  Lanes sum(const std::array<Lanes, Count>& weight, Lanes start) const noexcept {
    auto even = fused_multiply_add(weight[0], at_[0], start), odd = Lanes::broadcast(0);
    if constexpr (Count > 1) odd = weight[1] * at_[1];
    for (std::size_t k = 2; k < Count; ++k) {
      auto& chain = k % 2 == 0 ? even : odd;
      chain = fused_multiply_add(weight[k], at_[k], chain);
    }
    return even + odd;
  }

 private:
  static std::ptrdiff_t place(std::size_t frame) noexcept {
    return static_cast<std::ptrdiff_t>(frame) * Lanes::kCount;
  }

  std::array<Lanes, Count> at_;
};

}  // namespace tactus
