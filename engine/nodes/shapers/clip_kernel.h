#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// `low` wins where it is above `high`.
static inline tactus_real tactus_clip(tactus_real in, tactus_real low, tactus_real high) {
  return tactus_max(low, tactus_min(high, in));
}
