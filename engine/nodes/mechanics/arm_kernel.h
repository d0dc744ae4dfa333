#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

// Arms with several joints. From joint angles q an arm has the position of its tip, p(q), and the Jacobian
// J = dp/dq; a force F at the tip takes the torques tau = J^T F, so that F p' = tau q' (Craig, Introduction
// to Robotics, 3rd ed. 2005, section 5.9). Lengths in m, angles in rad, forces in N, torques in N m.

enum { TACTUS_ARM_JOINTS = 6, TACTUS_ARM_SIZES = 6 };
#define TACTUS_ARM_SHORTEST 1e-3  ///< length of a link [m]
#define TACTUS_ARM_LONGEST 10.0
#define TACTUS_ARM_HEAVIEST 100.0  ///< mass of a link [kg]
#define TACTUS_ARM_GRAVITY 9.80665

typedef struct tactus_arm_angles {
  tactus_real of[TACTUS_ARM_JOINTS];
} tactus_arm_angles;

/// Lengths, then masses, in the order of the ports.
typedef struct tactus_arm_sizes {
  tactus_real of[TACTUS_ARM_SIZES];
} tactus_arm_sizes;

/// Force and moment at the tip.
typedef struct tactus_arm_load {
  tactus_real force[3], moment[3];
} tactus_arm_load;

typedef struct tactus_arm_limits {
  tactus_real low[TACTUS_ARM_JOINTS], high[TACTUS_ARM_JOINTS];
} tactus_arm_limits;

/// What an arm is at its angles. What it has no axis or joint for is 0.
typedef struct tactus_arm_pose {
  tactus_real tip[3];
  tactus_real slide[3][TACTUS_ARM_JOINTS];  ///< [axis][joint] dp/dq
  tactus_real turn[3][TACTUS_ARM_JOINTS];   ///< axes of the joints: what a moment works on
  tactus_real facing[3][3];  ///< [column][axis] rotation matrix of the last link, columns pen, left, up
  tactus_real weight[TACTUS_ARM_JOINTS];  ///< torques that hold the masses
  int is_open;                            ///< the links of a closed chain do not reach each other
} tactus_arm_pose;

static inline tactus_arm_pose tactus_arm_nowhere(void) {
  tactus_arm_pose p;
  p.is_open = 0;
  for (int joint = 0; joint < TACTUS_ARM_JOINTS; ++joint) p.weight[joint] = 0;
  for (int axis = 0; axis < 3; ++axis) {
    p.tip[axis] = p.facing[0][axis] = p.facing[1][axis] = p.facing[2][axis] = 0;
    for (int joint = 0; joint < TACTUS_ARM_JOINTS; ++joint) p.slide[axis][joint] = p.turn[axis][joint] = 0;
  }
  return p;
}

static inline tactus_real tactus_arm_length(tactus_real length) {
  return tactus_clamp(length, TACTUS_ARM_SHORTEST, TACTUS_ARM_LONGEST);
}
static inline tactus_real tactus_arm_mass(tactus_real mass) {
  return tactus_clamp(mass, 0.0, TACTUS_ARM_HEAVIEST);
}

/// The torque at a joint: J^T F, what holds the weight, and a spring of `stop` [N m/rad] beyond its limits.
static inline tactus_real tactus_arm_torque(const tactus_arm_pose* p, const tactus_arm_load* load,
                                            tactus_arm_angles q, const tactus_arm_limits* limits,
                                            tactus_real stop, int joint) {
  const tactus_real angle = q.of[joint];
  tactus_real torque =
      p->weight[joint] +
      tactus_max(0.0, stop) * (tactus_clamp(angle, limits->low[joint], limits->high[joint]) - angle);
  for (int axis = 0; axis < 3; ++axis)
    torque += p->slide[axis][joint] * load->force[axis] + p->turn[axis][joint] * load->moment[axis];
  return torque;
}

/// 1 where a joint is beyond its limits, or where the links of a closed chain do not reach each other.
static inline tactus_real tactus_arm_at_limit(const tactus_arm_pose* p, tactus_arm_angles q,
                                              const tactus_arm_limits* limits) {
  int beyond = p->is_open;
  for (int joint = 0; joint < TACTUS_ARM_JOINTS; ++joint)
    beyond |= q.of[joint] < limits->low[joint] || q.of[joint] > limits->high[joint];
  return beyond;
}
