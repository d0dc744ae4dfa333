#pragma once

// Thread: [realtime]
#include <vector>

#include "engine/nodes/world/world_builder.h"

namespace tactus {

/// What a handle needs from frame to frame.
struct HandleState {
  int body = -1;                 ///< that it holds; -1: none
  bool fresh = true;             ///< it holds it from this frame on
  std::vector<Vector3> before;   ///< positions of the last step's frames, a ring
  Vector3 position{}, centre{};  ///< of the handle and its body, in the last frame
  Vector3 force{};               ///< on the body
  double stored = 0, lost = 0;   ///< in the spring; in the damper of the file, in the last frame [J]
  double generated = 0;          ///< J, at least 0
  Vector3 impulse{};             ///< on the body since the last step, N s
};

/// A handle that a spring and a damper couple to a body along each axis that is given; the damping rises
/// while sampling has generated energy (Hannaford & Ryu, IEEE Trans. Robotics and Automation 18, 2002):
///   f = K (p - c) + (B + b) (vp - vc) on the body at c, -f on the handle at p,  0 <= b <= passivity
struct HandleCoupling {
  const WorldHandle& model;
  int frames;  ///< of a step
  double frame_s, step_s;

  void reset(HandleState& state) const noexcept;
  void hold(HandleState& state, int body) const noexcept;
  /// The forces in a frame, `part` of the way from one step to the next, and the energy that they gave and
  /// took since the last one. `started`: there was a step.
  void move(HandleState& state, const Vector3& to, const RigidBodies& bodies, std::int64_t frame, double part,
            bool started) const noexcept;
  void collect(HandleState& state) const noexcept;
  void before_step(HandleState& state, RigidBodies& bodies) const noexcept;
  void after_step(HandleState& state, const RigidBodies& bodies) const noexcept;
};

}  // namespace tactus
