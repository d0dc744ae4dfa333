#pragma once

// Thread: [realtime].

#include "engine/dsp/simd/lanes.h"
#include "engine/nodes/logic/threshold_kernel.h"

namespace tactus {

/// Whether none of `count` finite samples changes anything; then they may be left out, but for
/// `tactus_threshold_pass`.
inline bool changes_nothing(const tactus_threshold& state, const double* in, int count, double level,
                            double hysteresis) noexcept {
  if (state.high == !state.fired) return false;
  return state.high ? !any_below(in, count, level - hysteresis) : !any_at_least(in, count, level);
}

}  // namespace tactus
