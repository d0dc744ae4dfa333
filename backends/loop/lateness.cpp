#include "backends/loop/lateness.h"

#include <algorithm>
#include <cmath>

namespace tactus {
namespace {

constexpr Seconds kMost{2.0};  // a driver begins anew then

}  // namespace

double Lateness::at(std::int64_t frame, Gaps& gaps) noexcept {
  for (const auto& drop : drops_) {
    if (!happens(drop, frame)) continue;
    at_start_ -= drop.frames;
    ++gaps.count;
    gaps.lost_frames += std::max(0, drop.frames);
  }
  const double later = at_start_ + growth_ * static_cast<double>(frame);
  return std::clamp(later, least_, frames_in(kMost, sample_rate_));
}

bool Lateness::happens(const LoopCard::Drop& drop, std::int64_t frame) const noexcept {
  const auto since = frame - std::llround(frames_in(drop.at, sample_rate_));
  const auto every = std::llround(frames_in(drop.every, sample_rate_));
  return since == 0 || (every > 0 && since > 0 && since % every == 0);
}

}  // namespace tactus
