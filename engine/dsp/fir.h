#pragma once

#include <algorithm>
#include <complex>
#include <utility>
#include <vector>

#include "engine/dsp/lanes.h"

namespace tactus {

/// y[n] = sum over k of taps[k] x[n-k], straight from the definition: no delay of its own, one multiply-add a
/// tap.
class Fir {
 public:
  /// [control] At least one tap.
  explicit Fir(std::vector<double> taps)
      : taps_(std::move(taps)), history_(taps_.size() - 1), inputs_(history_ + kRoom, 0.0), next_(history_) {}

  void reset() noexcept {
    std::fill(inputs_.begin(), inputs_.end(), 0.0);
    next_ = history_;
  }

  /// [realtime] Remembers the inputs that `other` heard, as many as it has taps.
  void adopt(const Fir& other) noexcept {
    const auto count = std::min(history_, other.history_);
    std::copy_n(other.inputs_.data() + (other.next_ - count), count, inputs_.data() + (next_ - count));
  }

  /// [realtime]
  void run(const double* x, double* y, int frames) noexcept {
    for (int done = 0; done < frames; done += kChunk)
      chunk(x + done, y + done, std::min(frames - done, kChunk));
  }

  std::complex<double> response(double radians) const {
    const auto delay = std::polar(1.0, -radians);
    std::complex<double> sum = 0;
    for (std::size_t k = taps_.size(); k-- > 0;) sum = sum * delay + taps_[k];
    return sum;
  }

 private:
  static constexpr int kChunk = 64;
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
    for (; n + Lanes::kCount <= frames; n += Lanes::kCount) {
      auto sum = Lanes::same(0);
      for (std::size_t k = 0; k < taps_.size(); ++k)
        sum = fused_multiply_add(Lanes::same(taps_[k]), Lanes::load(now + n - k), sum);
      sum.store(y + n);
    }
    for (; n < frames; ++n) {
      double sum = 0;
      for (std::size_t k = 0; k < taps_.size(); ++k) sum = fused_multiply_add(taps_[k], *(now + n - k), sum);
      y[n] = sum;
    }
  }

  std::vector<double> taps_;
  std::size_t history_;
  std::vector<double> inputs_;
  std::size_t next_;  ///< where the next input goes; `history_` older ones stand before it
};

}  // namespace tactus
