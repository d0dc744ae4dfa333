#pragma once

#include <span>
#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// A note that is to be played, or a glide from one to another.
struct ExpectedNote {
  double from_s = 0, to_s = 0;
  double begins_hz = 0, ends_hz = 0;
  double hertz = 0;  ///< median
  bool glides = false;

  double seconds() const { return to_s - from_s; }
};

/// [any] The notes in a pitch that is wanted in each frame (0: none). It steps to the next one where it jumps
/// by more than 5 cents from one frame to the next. In between it glides where it rises or falls by more than
/// half a semitone and does not swing back at once, as a vibrato does: a swing moves by at most 300 cents, in
/// a quarter of a second. What is shorter than 50 ms is no note, nor 0.1 s a glide.
std::vector<ExpectedNote> expected_notes(std::span<const double> expected_hz, Hertz rate);

}  // namespace tactus
