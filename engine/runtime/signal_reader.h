#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/core/index.h"
#include "engine/runtime/running.h"

namespace tactus {

/// Where the samples of a signal lie in the arena of a plan.
struct SignalPlace {
  const double* data = nullptr;
  std::ptrdiff_t stride = 1;
  int divider = 0;    ///< in Plan::divisors
  int control = -1;   ///< its stride is 0 while this control rests
  int can_rest = -1;  ///< the same, of Plan::can_rest
};

/// [realtime] Reads a signal, frame by frame, in the sub-block that was computed last.
class SignalReader {
 public:
  SignalReader() noexcept = default;
  SignalReader(const Running& running, const SignalPlace& place) noexcept
      : data_(place.data), divider_(place.divider == 0 ? nullptr : &running.dividers[index(place.divider)]) {
    const bool rests = (place.control >= 0 && running.controls[index(place.control)].resting) ||
                       (place.can_rest >= 0 && running.at_rest[index(place.can_rest)] != 0);
    stride_ = rests ? 0 : place.stride;
  }

  /// In frame `n` of the sub-block. A part with a rate keeps `before` until its next frame.
  double at(int n, double before) const noexcept {
    const int own = divider_ == nullptr ? n : divider_->count(n + 1) - 1;
    return own < 0 ? before : data_[own * stride_];
  }

 private:
  const double* data_ = nullptr;
  std::ptrdiff_t stride_ = 0;
  const RateDivider* divider_ = nullptr;
};

/// Sees all signals of a running player.
class SignalObserver {
 public:
  virtual ~SignalObserver() = default;
  /// [realtime] After the steps of each sub-block, whose first frame is `now`.
  virtual void observe(const Running& running, std::int64_t now, int frames) noexcept = 0;
};

}  // namespace tactus
