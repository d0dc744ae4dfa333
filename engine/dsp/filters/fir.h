#pragma once

// Thread: [realtime]; constructors [control].

#include <algorithm>
#include <array>
#include <complex>
#include <cstddef>
#include <utility>
#include <vector>

#include "engine/dsp/filters/filter_kernel.h"
#include "engine/dsp/simd/lanes.h"

namespace tactus {

/// `tactus_fir_frame`, vectorised: a single frame goes through its eight sums in one vector, eight frames in
/// a vector for each.
class Fir {
 public:
  /// [control] At least one tap.
  explicit Fir(std::vector<double> taps)
      : taps_(oldest_first(std::move(taps))),
        history_(taps_.size() - 1),
        inputs_(history_ + kRoom, 0.0),
        next_(history_) {}

  void reset() noexcept {
    std::fill(inputs_.begin(), inputs_.end(), 0.0);
    next_ = history_;
  }

  /// [realtime] Takes over the inputs of `other`, as many as it has taps.
  void adopt(const Fir& other) noexcept {
    const auto count = std::min(history_, other.history_);
    std::copy_n(other.inputs_.data() + (other.next_ - count), count, inputs_.data() + (next_ - count));
  }

  /// [realtime]
  void run(const double* x, double* y, int frames) noexcept {
    for (int done = 0; done < frames; done += kChunk)
      chunk(x + done, y + done, std::min(frames - done, kChunk));
  }

  /// H, where `delay` is z^-1.
  std::complex<double> response(std::complex<double> delay) const {
    std::complex<double> sum = 0;
    for (const double tap : taps_) sum = sum * delay + tap;
    return sum;
  }

 private:
  static constexpr int kChunk = 64;
  static constexpr std::size_t kSums = TACTUS_FIR_SUMS;
  static constexpr std::size_t kRoom = 512;  ///< new samples before the history moves back to the front

  void chunk(const double* x, double* y, int frames) noexcept {
    if (next_ + static_cast<std::size_t>(frames) > inputs_.size()) {
      std::copy_n(inputs_.data() + (next_ - history_), history_, inputs_.data());
      next_ = history_;
    }
    double* const now = inputs_.data() + next_;
    next_ += static_cast<std::size_t>(frames);
    copy_samples(x, frames, now);
    int n = 0;
    for (; n + Lanes::kCount <= frames; n += Lanes::kCount) eight_frames(now + n - history_).store(y + n);
    for (; n < frames; ++n) y[n] = one_frame(now + n - history_);
  }

  /// `oldest`: the input that the last tap of the first frame is for.
  Lanes eight_frames(const double* oldest) const noexcept {
    std::array<Lanes, kSums> sums;
    sums.fill(Lanes::broadcast(0));
    for (std::size_t k = 0; k < taps_.size(); k += kSums)
      for (std::size_t i = 0; i < kSums; ++i)
        sums[i] = fused_multiply_add(Lanes::broadcast(taps_[k + i]), Lanes::load(oldest + k + i), sums[i]);
    return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
  }
  double one_frame(const double* oldest) const noexcept {
    auto eight = Lanes::broadcast(0);
    for (std::size_t k = 0; k < taps_.size(); k += kSums)
      eight = fused_multiply_add(Lanes::load(&taps_[k]), Lanes::load(oldest + k), eight);
    std::array<double, kSums> sums;
    eight.store(sums.data());
    return tactus_fir_total(sums.data());
  }

  /// A multiple of kSums.
  static std::vector<double> oldest_first(std::vector<double> taps) {
    taps.resize((taps.size() + kSums - 1) / kSums * kSums);
    std::reverse(taps.begin(), taps.end());
    return taps;
  }

  std::vector<double> taps_;  ///< the last one first, with zeros before it
  std::size_t history_;
  std::vector<double> inputs_;
  std::size_t next_;  ///< where the next input goes; `history_` older ones stand before it
};

}  // namespace tactus
