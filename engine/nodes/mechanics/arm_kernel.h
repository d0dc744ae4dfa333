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
  tactus_real pen[3];                       ///< direction of the last link
  tactus_real weight[TACTUS_ARM_JOINTS];    ///< torques that hold the masses
  int is_open;                              ///< the links of a closed chain do not reach each other
} tactus_arm_pose;

static inline tactus_arm_pose tactus_arm_nowhere(void) {
  tactus_arm_pose p;
  p.is_open = 0;
  for (int joint = 0; joint < TACTUS_ARM_JOINTS; ++joint) p.weight[joint] = 0;
  for (int axis = 0; axis < 3; ++axis) {
    p.tip[axis] = p.pen[axis] = 0;
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
static inline tactus_real tactus_dot(const tactus_real* a, const tactus_real* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
static inline void tactus_cross(const tactus_real* a, const tactus_real* b, tactus_real* product) {
  product[0] = a[1] * b[2] - a[2] * b[1];
  product[1] = a[2] * b[0] - a[0] * b[2];
  product[2] = a[0] * b[1] - a[1] * b[0];
}

/// 1 / x where |x| >= 0.02, and from there a straight line through 0: where links of a closed chain come to
/// lie in one line or plane, a force at the tip would take torques without a limit.
static inline tactus_real tactus_arm_inverse(tactus_real x) {
  const tactus_real closest = 0.02;
  return fabs(x) < closest ? x / (closest * closest) : 1 / x;
}

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

/// Two motors at (-base/2, 0) and (base/2, 0), each with a link to an elbow, and a link from each elbow to
/// the tip, which is on the side of larger y while the elbows do not cross. The links u_i from the elbows
/// keep their length: u_i p' = u_i e_i', so J = A^-1 B with A of rows u_i and B = diag(u_i de_i/dq_i). Sizes:
/// base, link_1 (to the elbow), link_2 (to the tip). Campion, Wang & Hayward, The Pantograph Mk-II, IROS
/// 2005.
static inline tactus_arm_pose tactus_five_bar(tactus_arm_angles q, tactus_arm_sizes sizes) {
  tactus_arm_pose p = tactus_arm_nowhere();
  const tactus_real base = tactus_clamp(sizes.of[0], 0.0, TACTUS_ARM_LONGEST);
  const tactus_real first = tactus_arm_length(sizes.of[1]), second = tactus_arm_length(sizes.of[2]);
  const tactus_real c[2] = {cos(q.of[0]), cos(q.of[1])}, s[2] = {sin(q.of[0]), sin(q.of[1])};
  const tactus_real elbow[2][2] = {{-0.5 * base + first * c[0], first * s[0]},
                                   {0.5 * base + first * c[1], first * s[1]}};
  const tactus_real across[2] = {elbow[1][0] - elbow[0][0], elbow[1][1] - elbow[0][1]};
  const tactus_real apart = tactus_max(sqrt(across[0] * across[0] + across[1] * across[1]), 1e-12);
  const tactus_real high = second * second - 0.25 * apart * apart;
  const tactus_real up = sqrt(tactus_max(0.0, high)) / apart;
  tactus_real u[2][2], pull[2], inverse;
  p.is_open = high < 0;
  p.tip[0] = 0.5 * (elbow[0][0] + elbow[1][0]) - up * across[1];
  p.tip[1] = 0.5 * (elbow[0][1] + elbow[1][1]) + up * across[0];
  for (int i = 0; i < 2; ++i) {
    u[i][0] = (p.tip[0] - elbow[i][0]) / second;
    u[i][1] = (p.tip[1] - elbow[i][1]) / second;
    pull[i] = first * (u[i][1] * c[i] - u[i][0] * s[i]);
  }
  inverse = tactus_arm_inverse(u[0][0] * u[1][1] - u[0][1] * u[1][0]);
  p.slide[0][0] = u[1][1] * pull[0] * inverse;
  p.slide[0][1] = -u[0][1] * pull[1] * inverse;
  p.slide[1][0] = -u[1][0] * pull[0] * inverse;
  p.slide[1][1] = u[0][0] * pull[1] * inverse;
  return p;
}

/// Where three spheres of radius `length` about the elbows meet, on the side of larger z; where they do not,
/// as near to that as the length allows.
static inline void tactus_delta_tip(tactus_real elbow[3][3], tactus_real length, tactus_arm_pose* p) {
  tactus_real a[3], b[3], normal[3], from_a[3], from_b[3], centre[3], aa, bb, nn, far, up, along;
  for (int axis = 0; axis < 3; ++axis) {
    a[axis] = elbow[1][axis] - elbow[0][axis];
    b[axis] = elbow[2][axis] - elbow[0][axis];
  }
  tactus_cross(a, b, normal);
  aa = tactus_dot(a, a);
  bb = tactus_dot(b, b);
  nn = tactus_max(tactus_dot(normal, normal), 1e-24);
  tactus_cross(b, normal, from_a);
  tactus_cross(normal, a, from_b);
  for (int axis = 0; axis < 3; ++axis) centre[axis] = (aa * from_a[axis] + bb * from_b[axis]) / (2 * nn);
  far = tactus_dot(centre, centre);
  p->is_open = far > length * length;
  along = p->is_open ? length / sqrt(far) : 1.0;
  up = sqrt(tactus_max(0.0, length * length - far) / nn) * (normal[2] < 0 ? -1 : 1);
  for (int axis = 0; axis < 3; ++axis)
    p->tip[axis] = elbow[0][axis] + along * centre[axis] + up * normal[axis];
}

/// Three motors around the z axis, 120 degrees apart, the first one in direction x, each with a link to an
/// elbow; parallelograms from the elbows hold a platform that does not turn. At an angle of 0 a link points
/// outwards, and it turns towards z. J as for five bars. Sizes: base (radius of the motors less that of the
/// platform), link_1 (to the elbow), link_2 (to the platform). Clavel, DELTA, a fast robot with parallel
/// geometry, 18th Int. Symp. on Industrial Robots, 1988.
static inline tactus_arm_pose tactus_delta(tactus_arm_angles q, tactus_arm_sizes sizes) {
  tactus_arm_pose p = tactus_arm_nowhere();
  const tactus_real base = tactus_clamp(sizes.of[0], 0.0, TACTUS_ARM_LONGEST);
  const tactus_real first = tactus_arm_length(sizes.of[1]), second = tactus_arm_length(sizes.of[2]);
  const tactus_real half = 0.8660254037844386;
  const tactus_real out[3][2] = {{1, 0}, {-0.5, half}, {-0.5, -half}};
  tactus_real elbow[3][3], u[3][3], across[3][3], pull[3], inverse;
  for (int i = 0; i < 3; ++i) {
    const tactus_real reach = base + first * cos(q.of[i]);
    elbow[i][0] = reach * out[i][0];
    elbow[i][1] = reach * out[i][1];
    elbow[i][2] = first * sin(q.of[i]);
  }
  tactus_delta_tip(elbow, second, &p);
  for (int i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 3; ++axis) u[i][axis] = (p.tip[axis] - elbow[i][axis]) / second;
    pull[i] = first * (u[i][2] * cos(q.of[i]) - (u[i][0] * out[i][0] + u[i][1] * out[i][1]) * sin(q.of[i]));
  }
  for (int i = 0; i < 3; ++i) tactus_cross(u[(i + 1) % 3], u[(i + 2) % 3], across[i]);
  inverse = tactus_arm_inverse(tactus_dot(u[0], across[0]));
  for (int i = 0; i < 3; ++i)
    for (int axis = 0; axis < 3; ++axis) p.slide[axis][i] = across[i][axis] * pull[i] * inverse;
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
/// angles 0 it is stretched along x. Sizes: link_1 (upper arm), link_2 (forearm), link_3 (wrist to tip);
/// masses of the upper arm and the forearm, at their middles, and of the gimbal with the pen, at the wrist.
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
  const tactus_real vertical[3] = {0, 0, 1}, level[3] = {s1, -c1, 0};  // the shoulder lifts around `level`
  const tactus_real forearm[3] = {c3 * c1, c3 * s1, s3}, above[3] = {-s3 * c1, -s3 * s1, c3};
  tactus_real pitch[3], raised[3], from_elbow[3], from_base[3], from_wrist[3];
  for (int axis = 0; axis < 3; ++axis) {
    pitch[axis] = c4 * level[axis] - s4 * above[axis];
    raised[axis] = c4 * above[axis] + s4 * level[axis];
    p.pen[axis] = c5 * forearm[axis] + s5 * raised[axis];
    from_wrist[axis] = pen * p.pen[axis];
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
  tactus_arm_joint(&p, 5, p.pen, from_wrist);
  p.weight[2] = TACTUS_ARM_GRAVITY * fore_kg * fore * c3;
  p.weight[1] = TACTUS_ARM_GRAVITY * upper_kg * upper * c2 + p.weight[2];
  return p;
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
    tactus_cross(about, p->pen, moved);
    for (int axis = 0; axis < 3; ++axis) wrist[joint][axis] = p->slide[axis][joint] - pen * moved[axis];
  }
  return tactus_min(tactus_conditioning_3(wrist), tactus_conditioning_3(gimbal));
}
