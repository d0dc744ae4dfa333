#include "engine/dsp/simd/peak.h"

#include <algorithm>
#include <cmath>

#include "engine/core/every_block.h"
#include "engine/dsp/simd/lanes.h"

namespace tactus {

TACTUS_EVERY_BLOCK double highest_magnitude(const double* samples, int count, double so_far) noexcept {
  auto highest = Lanes::broadcast(so_far);
  int n = 0;
  for (; n + Lanes::kCount <= count; n += Lanes::kCount) {
    const auto here = Lanes::load(samples + n);
    highest = max(highest, max(here, -here));
  }
  double lanes[Lanes::kCount];
  highest.store(lanes);
  for (const double lane : lanes) so_far = std::max(so_far, lane);
  for (; n < count; ++n) so_far = std::max(so_far, std::abs(samples[n]));
  return so_far;
}

}  // namespace tactus
