#pragma once
// Thread: [realtime] unless stated otherwise

#include <array>
#include <cstdint>

#include "engine/core/index.h"
#include "engine/core/ramp.h"

namespace tactus {

/// The guard's models advance in groups of this many frames on the absolute frame grid: whatever the block
/// size, a model gets the same sums at the same frames.
inline constexpr int kGuardGroup = 64;

inline int guard_position(std::int64_t frame) noexcept { return static_cast<int>(frame & (kGuardGroup - 1)); }

/// A sum over the frames of a group in eight partial sums, chosen by the frame's position: vectorised, and
/// with the same additions in the same order for every block size.
struct GroupSum {
  static constexpr int kLanes = 8;
  std::array<double, kLanes> lanes{};

  /// [realtime] Adds term(n) for frames that begin at `position` of their group.
  template <class Term>
  void add(int position, int frames, Term term) noexcept {
    int n = 0;
    if (frames >= 2 * kLanes) {
      for (; ((position + n) & (kLanes - 1)) != 0; ++n) at(position + n) += term(n);
      auto sums = lanes;
      for (; n + kLanes <= frames; n += kLanes)
        for (int k = 0; k < kLanes; ++k) sums[index(k)] += term(n + k);
      lanes = sums;
    }
    for (; n < frames; ++n) at(position + n) += term(n);
  }
  /// [realtime] The sum; the next group starts at 0.
  double take() noexcept {
    const auto& s = lanes;
    const double sum = ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]));
    lanes.fill(0.0);
    return sum;
  }

 private:
  double& at(int place) noexcept { return lanes[index(place & (kLanes - 1))]; }
};

/// A gain that is set once per group and moves to its new value on a ramp through the next group.
class GroupGain {
 public:
  void move_to(double gain) noexcept { ramp_ = {ramp_.to, gain}; }
  double at(int position) const noexcept {
    return ramp_.at_progress(static_cast<double>(position + 1) / kGuardGroup);
  }
  bool idle() const noexcept { return ramp_.from == 1.0 && ramp_.to == 1.0; }
  double now() const noexcept { return ramp_.to; }
  /// Over the frames of the group.
  double mean() const noexcept {
    return ramp_.from + (ramp_.to - ramp_.from) * ((kGuardGroup + 1.0) / (2.0 * kGuardGroup));
  }

 private:
  Ramp ramp_ = Ramp::constant(1.0);
};

}  // namespace tactus
