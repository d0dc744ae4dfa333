#pragma once

// Thread: [any].

// Without AVX, GCC points out that code with AVX would pass a Four differently. No Four crosses a border
// between files that are compiled with different flags.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

namespace tactus {

/// Four doubles in one register (a vector type of GCC and Clang; without AVX it becomes two). The four bands
/// of the onset detector; Lanes would leave half of its register empty. Operators work lane by lane, `v[i]`
/// is a lane, a comparison gives a mask for `?:`.
using Four = double __attribute__((vector_size(32)));

inline Four max(const Four& a, const Four& b) { return a > b ? a : b; }
inline Four min(const Four& a, const Four& b) { return a < b ? a : b; }
inline Four abs(const Four& a) { return max(a, -a); }
/// Whether a > b in any lane.
inline bool any_above(const Four& a, const Four& b) {
  const auto above = a > b;
  return (above[0] | above[1] | above[2] | above[3]) != 0;
}

}  // namespace tactus
