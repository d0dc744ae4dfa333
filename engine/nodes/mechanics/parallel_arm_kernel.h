#pragma once

// Thread: [realtime].

#include "engine/nodes/mechanics/arm_kernel.h"
#include "engine/nodes/mechanics/vector_kernel.h"

// Arms whose links form closed chains: motors at the base turn links to elbows, and a link of constant length
// from each elbow holds the tip.

/// 1 / x where |x| >= 0.02, and from there a straight line through 0: where links of a closed chain come to
/// lie in one line or plane, a force at the tip would take torques without a limit.
static inline tactus_real tactus_arm_inverse(tactus_real x) {
  const tactus_real closest = 0.02;
  return fabs(x) < closest ? x / (closest * closest) : 1 / x;
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
