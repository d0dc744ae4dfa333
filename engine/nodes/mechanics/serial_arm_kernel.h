#pragma once

// Thread: [realtime].

#include "engine/nodes/mechanics/arm_kernel.h"
#include "engine/nodes/mechanics/vector_kernel.h"

// Arms whose joints follow one another: the tip is the sum of the links, and a column of J the motion that
// its joint gives it. Craig, Introduction to Robotics, 3rd ed. 2005, chapter 3.

/// Two links in a plane; the second angle is measured from the first link. Sizes: link_1, link_2.
static inline tactus_arm_pose tactus_two_link(tactus_arm_angles q, tactus_arm_sizes sizes) {
  tactus_arm_pose p = tactus_arm_nowhere();
  const tactus_real first = tactus_arm_length(sizes.of[0]), second = tactus_arm_length(sizes.of[1]);
  const tactus_real x = second * cos(q.of[0] + q.of[1]), y = second * sin(q.of[0] + q.of[1]);
  p.tip[0] = first * cos(q.of[0]) + x;
  p.tip[1] = first * sin(q.of[0]) + y;
  p.slide[0][0] = -p.tip[1];
  p.slide[1][0] = p.tip[0];
  p.slide[0][1] = -y;
  p.slide[1][1] = x;
  return p;
}

/// The column of a joint that turns around `about` and carries the tip at `arm` from it.
static inline void tactus_arm_joint(tactus_arm_pose* p, int joint, const tactus_real* about,
                                    const tactus_real* arm) {
  tactus_real moved[3];
  tactus_cross(about, arm, moved);
  for (int axis = 0; axis < 3; ++axis) {
    p->slide[axis][joint] = moved[axis];
    p->turn[axis][joint] = about[axis];
  }
}

/// Six joints in a row: base around z; shoulder, 0 level; elbow, measured from the upper arm; then a gimbal
/// whose axes meet at the wrist: roll around the forearm, pitch of the pen, roll around the pen. With all
/// angles 0 it is stretched along x, and the columns pen, left and up of its orientation are x, y and z.
/// Sizes: link_1 (upper arm), link_2 (forearm), link_3 (wrist to tip); masses of the upper arm and the
/// forearm, at their middles, and of the gimbal with the pen, at the wrist.
static inline tactus_arm_pose tactus_six_axis(tactus_arm_angles q, tactus_arm_sizes sizes) {
  tactus_arm_pose p = tactus_arm_nowhere();
  const tactus_real upper = tactus_arm_length(sizes.of[0]), fore = tactus_arm_length(sizes.of[1]);
  const tactus_real pen = tactus_clamp(sizes.of[2], 0.0, TACTUS_ARM_LONGEST);
  const tactus_real lower_mass = tactus_arm_mass(sizes.of[4]), wrist_mass = tactus_arm_mass(sizes.of[5]);
  const tactus_real upper_kg = 0.5 * tactus_arm_mass(sizes.of[3]) + lower_mass + wrist_mass;
  const tactus_real fore_kg = 0.5 * lower_mass + wrist_mass;
  const tactus_real c1 = cos(q.of[0]), s1 = sin(q.of[0]), c2 = cos(q.of[1]), s2 = sin(q.of[1]);
  const tactus_real c3 = cos(q.of[1] + q.of[2]), s3 = sin(q.of[1] + q.of[2]);
  const tactus_real c4 = cos(q.of[3]), s4 = sin(q.of[3]), c5 = cos(q.of[4]), s5 = sin(q.of[4]);
  const tactus_real c6 = cos(q.of[5]), s6 = sin(q.of[5]);
  const tactus_real vertical[3] = {0, 0, 1}, level[3] = {s1, -c1, 0};  // the shoulder lifts around `level`
  const tactus_real forearm[3] = {c3 * c1, c3 * s1, s3}, above[3] = {-s3 * c1, -s3 * s1, c3};
  tactus_real pitch[3], raised[3], across[3], from_elbow[3], from_base[3], from_wrist[3];
  for (int axis = 0; axis < 3; ++axis) {
    pitch[axis] = c4 * level[axis] - s4 * above[axis];
    raised[axis] = c4 * above[axis] + s4 * level[axis];
    p.facing[0][axis] = c5 * forearm[axis] + s5 * raised[axis];
    across[axis] = c5 * raised[axis] - s5 * forearm[axis];
    p.facing[1][axis] = s6 * across[axis] - c6 * pitch[axis];
    p.facing[2][axis] = c6 * across[axis] + s6 * pitch[axis];
    from_wrist[axis] = pen * p.facing[0][axis];
    from_elbow[axis] = fore * forearm[axis] + from_wrist[axis];
  }
  from_base[0] = upper * c2 * c1 + from_elbow[0];
  from_base[1] = upper * c2 * s1 + from_elbow[1];
  from_base[2] = upper * s2 + from_elbow[2];
  for (int axis = 0; axis < 3; ++axis) p.tip[axis] = from_base[axis];
  tactus_arm_joint(&p, 0, vertical, from_base);
  tactus_arm_joint(&p, 1, level, from_base);
  tactus_arm_joint(&p, 2, level, from_elbow);
  tactus_arm_joint(&p, 3, forearm, from_wrist);
  tactus_arm_joint(&p, 4, pitch, from_wrist);
  tactus_arm_joint(&p, 5, p.facing[0], from_wrist);
  p.weight[2] = TACTUS_ARM_GRAVITY * fore_kg * fore * c3;
  p.weight[1] = TACTUS_ARM_GRAVITY * upper_kg * upper * c2 + p.weight[2];
  return p;
}
