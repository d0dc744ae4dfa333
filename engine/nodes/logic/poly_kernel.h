#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/envelope_kernel.h"

/// One of several voices that share the notes of a player.
typedef struct tactus_voice {
  tactus_real pitch, level;
  long long since;  ///< number of the event that started or released it; 0: it has not played
  int held, starts;
} tactus_voice;

typedef struct tactus_poly {
  tactus_rise on, off;
  long long events;
} tactus_poly;

/// The voice for a note: the one that holds the same pitch, else the one released longest ago (or not played
/// yet), else, if `steal`, the one that started longest ago; -1: none.
static inline int tactus_poly_voice_for(const tactus_voice* voices, int count, tactus_real pitch, int steal) {
  int best = -1;
  for (int k = 0; k < count; ++k) {
    if (voices[k].held && voices[k].pitch == pitch) return k;
    if (voices[k].held && !steal) continue;
    if (best < 0 || voices[k].held < voices[best].held ||
        (voices[k].held == voices[best].held && voices[k].since < voices[best].since))
      best = k;
  }
  return best;
}

/// Releases before it starts in the same frame. `starts` of a voice is 1 in the frame in which it begins a
/// note.
static inline void tactus_poly_step(tactus_poly* s, tactus_voice* voices, int count, int steal,
                                    tactus_real on, tactus_real off, tactus_real pitch, tactus_real level) {
  const int starts = tactus_rise_step(&s->on, on), releases = tactus_rise_step(&s->off, off);
  int k;
  for (k = 0; k < count; ++k) voices[k].starts = 0;
  if (releases)
    for (k = 0; k < count; ++k)
      if (voices[k].held && voices[k].pitch == pitch) {
        voices[k].held = 0;
        voices[k].since = ++s->events;
      }
  k = starts ? tactus_poly_voice_for(voices, count, pitch, steal) : -1;
  if (k < 0) return;
  voices[k].pitch = pitch;
  voices[k].level = level;
  voices[k].since = ++s->events;
  voices[k].held = voices[k].starts = 1;
}
