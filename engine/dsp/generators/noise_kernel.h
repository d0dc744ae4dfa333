#pragma once

// Thread: [realtime].

#include "engine/dsp/kernel.h"

/// Noise as a function of the frame number instead of a running generator: frames can be computed
/// in any order, so that blocks, restarts and lanes cannot change it.
///   u(n) = mix(key + (n + 1) * 0x9e3779b97f4a7c15),  key = mix(mix(seed) + lane)
/// `mix` is the finaliser of SplitMix64 (Steele, Lea, Flood, "Fast splittable pseudorandom number
/// generators", OOPSLA 2014, with the constants of Stafford's variant 13), modulo 2^64.
typedef unsigned long long tactus_noise_bits;

static inline tactus_noise_bits tactus_noise_mix(tactus_noise_bits z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}
static inline tactus_noise_bits tactus_noise_key(tactus_noise_bits seed, tactus_noise_bits lane) {
  return tactus_noise_mix(tactus_noise_mix(seed) + lane);
}
static inline tactus_noise_bits tactus_noise_at(tactus_noise_bits key, tactus_noise_bits counter) {
  return tactus_noise_mix(key + (counter + 1) * 0x9e3779b97f4a7c15u) >> 11;
}

/// Even in [-1, 1): mean 0, variance 1/3.
static inline tactus_real tactus_noise_uniform(tactus_noise_bits key, tactus_noise_bits frame) {
  return (tactus_real)tactus_noise_at(key, frame) * 0x1p-52 - 1.0;
}

/// Normal, mean 0, variance 1, |value| < 8.6. Box and Muller (1958), the cosine half.
static inline tactus_real tactus_noise_gaussian(tactus_noise_bits key, tactus_noise_bits frame) {
  const tactus_real radius = (tactus_real)(tactus_noise_at(key, 2 * frame) + 1) * 0x1p-53;  // never 0
  const tactus_real turn = (tactus_real)tactus_noise_at(key, 2 * frame + 1) * 0x1p-53;
  return sqrt(-2.0 * log(radius)) * cos(6.283185307179586 * turn);
}
