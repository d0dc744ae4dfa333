#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/envelope_kernel.h"

/// The voltage that moves a voice coil as planned. The planned velocity passes three one-pole low-passes, so
/// that its first and second differences have no peaks at corners of the plan; the position is its sum, which
/// leaks so that a plan that does not return leaves no offset.
typedef struct tactus_actuator_inverse {
  tactus_time_constant smoothing, centring;
  tactus_real smooth[3];  ///< the last one: velocity
  tactus_real acceleration, position;
} tactus_actuator_inverse;

/// Resistance [ohm], inductance [H], force factor [T m]; moving mass [kg], damping [N s/m], stiffness [N/m].
typedef struct tactus_actuator {
  tactus_real resistance, inductance, force_factor, mass, damping, stiffness;
} tactus_actuator;

static inline tactus_actuator tactus_actuator_limited(const tactus_actuator* a) {
  tactus_actuator limited;
  limited.resistance = tactus_clamp(a->resistance, 0.0, 1e6);
  limited.inductance = tactus_clamp(a->inductance, 0.0, 1e3);
  limited.force_factor = tactus_clamp(a->force_factor, 1e-3, 1e6);
  limited.mass = tactus_clamp(a->mass, 0.0, 1e6);
  limited.damping = tactus_clamp(a->damping, 0.0, 1e9);
  limited.stiffness = tactus_clamp(a->stiffness, 0.0, 1e9);
  return limited;
}

/// The voltage [V] for a planned velocity [m/s]; smoothing and centring are time constants [s].
static inline tactus_real tactus_actuator_inverse_step(tactus_actuator_inverse* s, tactus_real velocity,
                                                       const tactus_actuator* given, tactus_real smoothing,
                                                       tactus_real centring, tactus_real rate) {
  const tactus_actuator a = tactus_actuator_limited(given);
  const tactus_real keep = tactus_time_constant_keep(&s->smoothing, tactus_clamp(smoothing, 0.0, 1.0), rate);
  const tactus_real stays = tactus_time_constant_keep(&s->centring, tactus_clamp(centring, 0.0, 1e3), rate);
  const tactus_real velocity_before = s->smooth[2], acceleration_before = s->acceleration;
  tactus_real jerk, current, current_rate;
  s->smooth[0] = velocity + keep * (s->smooth[0] - velocity);
  s->smooth[1] = s->smooth[0] + keep * (s->smooth[1] - s->smooth[0]);
  s->smooth[2] = s->smooth[1] + keep * (s->smooth[2] - s->smooth[1]);
  s->acceleration = (s->smooth[2] - velocity_before) * rate;
  s->position = stays * s->position + s->smooth[2] / rate;
  jerk = (s->acceleration - acceleration_before) * rate;
  current =
      (a.mass * s->acceleration + a.damping * s->smooth[2] + a.stiffness * s->position) / a.force_factor;
  current_rate = (a.mass * jerk + a.damping * s->acceleration + a.stiffness * s->smooth[2]) / a.force_factor;
  return a.resistance * current + a.inductance * current_rate + a.force_factor * s->smooth[2];
}
