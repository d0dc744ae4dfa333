#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// Two equal real poles, y'' = w^2 (x - y) - 2 w y'.
typedef struct tactus_critical_low_pass {
  tactus_real value, slope;
} tactus_critical_low_pass;

/// One step of `time` seconds, exact for an input that is held; decay = exp(-pole time).
static inline void tactus_critical_low_pass_step(tactus_critical_low_pass* s, tactus_real input,
                                                 tactus_real pole, tactus_real time, tactus_real decay) {
  const tactus_real away = s->value - input;
  const tactus_real push = (s->slope + pole * away) * time;
  s->value = input + (away + push) * decay;
  s->slope = (s->slope - pole * push) * decay;
}
