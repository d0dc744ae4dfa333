#pragma once

#include <array>
#include <atomic>

#include "engine/core/spsc_queue.h"
#include "engine/graph/body_source.h"
#include "engine/nodes/world/world_builder.h"

namespace tactus {

/// Copies what one world shows to one other thread. Neither waits: there are three copies, one of which the
/// audio thread fills, one the other thread reads, and the newest complete one lies between them.
class WorldWatch {
 public:
  /// [control]
  explicit WorldWatch(const WorldRecipe& recipe);

  /// [any]
  const BodyLooks& looks() const { return looks_; }
  void watch_poses(bool on) noexcept { poses_wanted_.store(on, std::memory_order_relaxed); }
  void watch_impacts(bool on) noexcept { impacts_wanted_.store(on, std::memory_order_relaxed); }
  /// [any, one thread]
  bool take_poses(BodyPoses& poses);
  bool take_impact(BodyImpact& impact) { return impacts_.pop(impact); }

  /// [realtime] Where poses are wanted: those to fill in, which `publish` makes visible.
  BodyPoses* begin() noexcept {
    return poses_wanted_.load(std::memory_order_relaxed) ? &copies_[filled_] : nullptr;
  }
  void publish() noexcept;
  /// [realtime]
  void add_bodies(const RigidBodies& bodies, double step_s, BodyPoses& poses) noexcept;
  void add_impacts(const RigidBodies& bodies, std::int64_t frame) noexcept;

 private:
  static constexpr double kLeastImpact_m_per_s = 0.02;
  static constexpr unsigned kFresh = 4;  ///< added to the number of a copy that nobody has read

  BodyLooks looks_;
  std::array<BodyPoses, 3> copies_;
  std::vector<Vector3> before_;  ///< velocities of the last step that was shown
  unsigned filled_ = 0, read_ = 1;
  std::atomic<unsigned> newest_{2};
  SpscQueue<BodyImpact> impacts_{256};
  std::atomic<bool> poses_wanted_{false}, impacts_wanted_{false};
};

}  // namespace tactus
