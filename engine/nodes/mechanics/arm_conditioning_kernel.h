#pragma once

// Thread: [realtime].

#include "engine/nodes/mechanics/arm_kernel.h"
#include "engine/nodes/mechanics/vector_kernel.h"

// How far an arm is from its singularities.

/// Smallest over largest singular value of a matrix of two rows and columns: |det| / largest^2.
static inline tactus_real tactus_conditioning_2(tactus_real a, tactus_real b, tactus_real c, tactus_real d) {
  const tactus_real det = fabs(a * d - b * c), sum = a * a + b * b + c * c + d * d;
  const tactus_real largest = 0.5 * (sum + sqrt(tactus_max(0.0, sum * sum - 4 * det * det)));
  return largest > 0 ? tactus_min(1.0, det / largest) : 0.0;
}

/// The same of three columns, by the eigenvalues e of their products (Smith, Communications of the ACM 4,
/// 1961): smallest / largest = |det| / (largest^2 middle).
static inline tactus_real tactus_conditioning_3(tactus_real m[3][3]) {
  tactus_real product[6], across[3], det, mean, spread, turn, largest, middle, centred;
  for (int i = 0; i < 3; ++i) {
    product[i] = tactus_dot(m[i], m[i]);
    product[3 + i] = tactus_dot(m[(i + 1) % 3], m[(i + 2) % 3]);
  }
  tactus_cross(m[1], m[2], across);
  det = fabs(tactus_dot(m[0], across));
  mean = (product[0] + product[1] + product[2]) / 3;
  spread = 0;
  for (int i = 0; i < 3; ++i)
    spread += (product[i] - mean) * (product[i] - mean) + 2 * product[3 + i] * product[3 + i];
  spread = sqrt(spread / 6);
  if (!(mean > 0)) return 0;
  if (spread < 1e-12 * mean) return 1;
  centred = (product[0] - mean) * ((product[1] - mean) * (product[2] - mean) - product[3] * product[3]) -
            product[5] * (product[5] * (product[2] - mean) - product[3] * product[4]) +
            product[4] * (product[5] * product[3] - (product[1] - mean) * product[4]);
  turn = acos(tactus_clamp(0.5 * centred / (spread * spread * spread), -1.0, 1.0)) / 3;
  largest = mean + 2 * spread * cos(turn);
  middle = mean + 2 * spread * cos(turn - 2.0943951023931953);
  return middle > 0 ? tactus_min(1.0, det / (largest * sqrt(middle))) : 0.0;
}

/// How far the tip is from places where it cannot be moved, or not be held, in some direction: smallest over
/// largest singular value of J, 1 where all directions are alike, 0 at a singularity (Salisbury & Craig, Int.
/// J. Robotics Research 1(1), 1982).
static inline tactus_real tactus_arm_conditioning(const tactus_arm_pose* p, int axes) {
  tactus_real columns[3][3];
  if (axes == 2) return tactus_conditioning_2(p->slide[0][0], p->slide[0][1], p->slide[1][0], p->slide[1][1]);
  for (int joint = 0; joint < 3; ++joint)
    for (int axis = 0; axis < 3; ++axis) columns[joint][axis] = p->slide[axis][joint];
  return tactus_conditioning_3(columns);
}

/// The same of the wrist and of the gimbal of six axes; the smaller of both.
static inline tactus_real tactus_six_axis_conditioning(const tactus_arm_pose* p, tactus_arm_sizes sizes) {
  const tactus_real pen = tactus_clamp(sizes.of[2], 0.0, TACTUS_ARM_LONGEST);
  tactus_real wrist[3][3], gimbal[3][3], moved[3];
  for (int joint = 0; joint < 3; ++joint) {
    tactus_real about[3];
    for (int axis = 0; axis < 3; ++axis) {
      about[axis] = p->turn[axis][joint];
      gimbal[joint][axis] = p->turn[axis][joint + 3];
    }
    tactus_cross(about, p->facing[0], moved);
    for (int axis = 0; axis < 3; ++axis) wrist[joint][axis] = p->slide[axis][joint] - pen * moved[axis];
  }
  return tactus_min(tactus_conditioning_3(wrist), tactus_conditioning_3(gimbal));
}
