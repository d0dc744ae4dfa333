#pragma once

#include <cstdint>

#include "engine/dsp/generators/noise_kernel.h"

namespace tactus {

/// [realtime] The noise of `noise_kernel.h` for one seed and lane.
class CounterNoise {
 public:
  CounterNoise(std::uint64_t seed, std::uint64_t lane) : key_(tactus_noise_key(seed, lane)) {}

  double uniform(std::int64_t frame) const {
    return tactus_noise_uniform(key_, static_cast<tactus_noise_bits>(frame));
  }
  double gaussian(std::int64_t frame) const {
    return tactus_noise_gaussian(key_, static_cast<tactus_noise_bits>(frame));
  }

 private:
  tactus_noise_bits key_;
};

}  // namespace tactus
