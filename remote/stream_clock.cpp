#include "remote/stream_clock.h"

#include <algorithm>
#include <cmath>

namespace tactus {
namespace {

constexpr double kLost_s = 0.1;      // an error that is no jitter
constexpr double kTime_s = 2.0;      // in which the loop follows
constexpr double kMostDrift = 5e-4;  // of the rate of a card against the system clock

}  // namespace

void StreamClock::update(double time_s, std::int64_t frame) {
  const double passed = time_s - time_s_;
  const double error = static_cast<double>(frame) - frame_at(time_s);
  if (readings_ == 0 || passed < 0 || std::abs(error) > kLost_s * nominal_) {
    rate_ = nominal_;
    base_ = static_cast<double>(frame);
    time_s_ = time_s;
    readings_ = 1;
    return;
  }
  if (readings_ < (1 << 20)) ++readings_;
  // A critically damped loop; at first the mean of the readings.
  const double share = std::min(1.0, passed / kTime_s);
  base_ += rate_ * passed + std::max(2.0 * share, 1.0 / readings_) * error;
  time_s_ = time_s;
  if (known()) rate_ += share / kTime_s * error;
  rate_ = std::clamp(rate_, nominal_ * (1 - kMostDrift), nominal_ * (1 + kMostDrift));
}

}  // namespace tactus
