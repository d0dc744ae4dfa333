#include "engine/guard/dc_limiter.h"

#include <algorithm>
#include <cmath>

namespace tactus {

DcLimiter::DcLimiter(const DcLimits& limits, Hertz sample_rate)
    : limited_(limits.level < 1.0),
      level_(limits.level),
      time_s_(limits.time.value),
      step_s_(kGuardGroup / sample_rate.value),
      mean_share_(-std::expm1(-step_s_ / kMean_s)) {}

void DcLimiter::end_group() noexcept {
  if (!limited_) return;
  mean_ += (sum_.take() / kGuardGroup - mean_) * mean_share_;
  const double size = std::abs(mean_);
  spent_s_ = std::clamp(spent_s_ + (size > level_ ? step_s_ : -step_s_), 0.0, time_s_);
  const double target = size > level_ && spent_s_ >= time_s_ ? level_ / size : 1.0;
  const double step = kGainPerSecond * step_s_;
  gain_.move_to(std::clamp(target, gain_.now() - step, gain_.now() + step));
}

}  // namespace tactus
