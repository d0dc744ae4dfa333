#pragma once

// Thread: [realtime]
#include <ode/ode.h>

#include <array>
#include <cstring>

#include "engine/nodes/world/rigid_bodies.h"

// What the parts of a world share that call the library.
namespace tactus {

struct OdeBody {
  dBodyID body = nullptr;  ///< of what moves
  dGeomID geom = nullptr;
  BodyState state = {};  ///< its size and mass
  Vector3 inertia{};
  bool present = true;
};

inline double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vector3 vector_of(const dReal* v) { return {v[0], v[1], v[2]}; }

/// Spread evenly.
inline dMass mass_of(WorldShape shape, const BodyState& state) {
  dMass mass;
  const auto& size = state.size;
  if (shape == WorldShape::Sphere)
    dMassSetSphereTotal(&mass, state.mass, size[0]);
  else if (shape == WorldShape::Box)
    dMassSetBoxTotal(&mass, state.mass, size[0], size[1], size[2]);
  else
    dMassSetCapsuleTotal(&mass, state.mass, 3, size[0], size[1]);
  return mass;
}

/// Where a body is and how it is turned, to the last bit.
struct OdePose {
  std::array<double, 3> position{};
  dQuaternion turn{};
  dMatrix3 rotation{};
};

inline OdePose pose_of(dBodyID body) {
  OdePose pose{vector_of(dBodyGetPosition(body))};
  std::memcpy(pose.turn, dBodyGetQuaternion(body), sizeof(dQuaternion));
  std::memcpy(pose.rotation, dBodyGetRotation(body), sizeof(dMatrix3));
  return pose;
}

inline void set_pose(dBodyID body, const OdePose& pose) {
  dBodySetPosition(body, pose.position[0], pose.position[1], pose.position[2]);
  dBodySetQuaternion(body, pose.turn);
  // Setting it normalised it again, which changes last bits.
  std::memcpy(const_cast<double*>(dBodyGetQuaternion(body)), pose.turn, sizeof(dQuaternion));
  std::memcpy(const_cast<double*>(dBodyGetRotation(body)), pose.rotation, sizeof(dMatrix3));
}

}  // namespace tactus
