#pragma once

// Thread: [any].

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus {

/// Delay that makes a loop a whole number of periods long at its pitch:
///
///   pad = k P − rest,   rest = delay − phase P / 2π
///
/// P [s] is one period, `delay` [s] what the loop takes without the pad, `phase` [rad] what turns in it
/// besides (below 0 it lags). k is chosen when a note starts, the least with a pad of at least `shortest`;
/// after that the pad follows P with the same k, from `shortest` to `shortest` + 1.5 P: so wide that a
/// vibrato at one end of it moves to the middle and stays there. Source: Berdahl, Steiner & Oldham, NIME
/// 2008, section 7.2, for the loop; k P from the condition of oscillation (Barkhausen).
struct LoopPad {
  double shortest;  ///< [s]

  static double rest(double period, double delay, double phase) noexcept {
    return delay - phase * period / (2 * std::numbers::pi);
  }
  /// k of a new note.
  double turns(double period, double rest) const noexcept { return std::ceil((rest + shortest) / period); }
  /// Whether k still serves.
  bool serves(double turns, double period, double rest) const noexcept {
    const double pad = turns * period - rest;
    return pad >= shortest && pad <= longest(period);
  }
  double longest(double period) const noexcept { return shortest + 1.5 * period; }
};

}  // namespace tactus
