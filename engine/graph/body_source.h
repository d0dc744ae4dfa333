#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

// What screens and messages show of the rigid bodies of a node.

namespace tactus {

/// Joints between two bodies, in the order of their numbers, which begin at 1.
inline constexpr std::array kJointNames = {"hinge",     "slider", "ball",  "fixed",
                                           "universal", "hinge2", "piston"};

/// What stays of a body for as long as it is computed.
struct BodyLook {
  std::string name;
  std::string shape;  ///< "sphere", "box", "capsule", "plane"
  int number = 0;     ///< among the bodies of the file, from 1
  bool moves = true;
  std::array<double, 3> normal{};  ///< of a plane, whose points p have normal . p = offset
  double offset = 0;
};

struct BodyLooks {
  std::vector<BodyLook> bodies;
  std::vector<std::string> handles;
};

/// A body after a step; SI.
struct BodyPose {
  bool present = true;
  std::array<double, 3> position{}, velocity{}, acceleration{};
  std::array<double, 4> turn{1, 0, 0, 0};  ///< unit quaternion: w, x, y, z
  std::array<double, 3> size{};            ///< radius; width, depth, height; radius, length
};

struct HandlePose {
  int holds = -1;                             ///< in BodyLooks::bodies; -1: nothing
  std::array<double, 3> position{}, force{};  ///< force on the handle
};

struct BodyPoses {
  std::int64_t frame = 0;
  std::vector<BodyPose> bodies;     ///< in the order of BodyLooks
  std::vector<HandlePose> handles;  ///< likewise
};

/// Two bodies that did not touch in the step before.
struct BodyImpact {
  int one = 0, other = 0;  ///< in BodyLooks::bodies
  double speed = 0;        ///< of approach [m/s]
  double impulse = 0;      ///< [N s]
  std::int64_t frame = 0;  ///< of the step
};

/// A node with rigid bodies, as another thread watches it while it runs. What nobody watches costs nothing.
class BodySource {
 public:
  virtual ~BodySource() = default;

  /// [any]
  virtual const BodyLooks& looks() const = 0;
  /// [any] From the next step on.
  virtual void watch_poses(bool on) noexcept = 0;
  virtual void watch_impacts(bool on) noexcept = 0;
  /// [any, one thread] Those of the newest step, into a vector that keeps its memory. False: there was no
  /// step since the last call.
  virtual bool take_poses(BodyPoses& poses) = 0;
  /// [any, one thread] The oldest one. False: there is none. Where nobody takes them, they are lost.
  virtual bool take_impact(BodyImpact& impact) = 0;
};

}  // namespace tactus
