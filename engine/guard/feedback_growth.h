#pragma once
// Thread: [realtime] unless stated otherwise

#include <algorithm>
#include <cmath>

#include "engine/core/units.h"
#include "engine/guard/guard_group.h"

namespace tactus {

/// Whether what a limited drive is asked to do grows without bound, as a loop of the graph does that
/// diverges:
///   level   the peak of the wanted signal over the last 32 ms, every 11 ms, in nepers above the ceiling
///   grows   level > ln 10^4, or: it rose by 40 dB above the ceiling, never fell by more than 1.5 dB on the
///           way, and a straight line over time explains 97 % of its variance
class FeedbackGrowth {
 public:
  /// [control]
  FeedbackGrowth(Hertz sample_rate, double ceiling)
      : groups_(std::max(1, static_cast<int>(std::lround(kStep_s * sample_rate.value / kGuardGroup)))),
        ceiling_(ceiling) {}

  void observe(double wanted) noexcept { peak_ = std::max(peak_, std::abs(wanted)); }
  /// A group is over. True: it grows.
  bool end_group() noexcept {
    if (++group_ < groups_) return grows_;
    group_ = 0;
    const double level = std::log(std::max({peak_, before_, earlier_, ceiling_}) / ceiling_);
    earlier_ = before_;
    before_ = peak_;
    peak_ = 0.0;
    if (n_ > 0.0 && level < highest_ - kFall) restart();
    add(level);
    grows_ = level > kHuge || is_straight();
    return grows_;
  }
  void forget() noexcept {
    restart();
    peak_ = before_ = earlier_ = 0.0;
    group_ = 0;
    grows_ = false;
  }

 private:
  static constexpr double kStep_s = 0.0107;
  static constexpr double kHuge = 9.21, kRise = 4.605, kFall = 0.17;  ///< nepers
  static constexpr double kStraight = 0.97;
  static constexpr int kLeastSteps = 6;

  void restart() noexcept { n_ = t_ = l_ = tt_ = tl_ = ll_ = 0.0; }
  void add(double level) noexcept {
    lowest_ = n_ == 0.0 ? level : std::min(lowest_, level);
    highest_ = n_ == 0.0 ? level : std::max(highest_, level);
    t_ += n_;
    l_ += level;
    tt_ += n_ * n_;
    tl_ += n_ * level;
    ll_ += level * level;
    n_ += 1.0;
  }
  bool is_straight() const noexcept {
    if (n_ < kLeastSteps || highest_ - lowest_ < kRise) return false;
    const double tt = tt_ - t_ * t_ / n_, ll = ll_ - l_ * l_ / n_, tl = tl_ - t_ * l_ / n_;
    return tl > 0.0 && tl * tl > kStraight * tt * ll;
  }

  int groups_;  ///< of a step
  double ceiling_;
  int group_ = 0;
  double peak_ = 0.0, before_ = 0.0, earlier_ = 0.0;  ///< of the last steps
  double lowest_ = 0.0, highest_ = 0.0;
  double n_ = 0.0, t_ = 0.0, l_ = 0.0, tt_ = 0.0, tl_ = 0.0, ll_ = 0.0;  ///< sums of the line
  bool grows_ = false;
};

}  // namespace tactus
