#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "engine/dsp/pitch/pitch_detector.h"

namespace tactus {

/// A note is right within a quarter of a semitone, where singers begin to call it wrong. Source: Vurma &
/// Ross, "Production and perception of musical intervals", Music Perception 23, 2006.
inline constexpr double kInTune_cents = 25;
/// So near a pitch is still this partial, and no other.
inline constexpr double kNearPartial_cents = 50;
/// A tone that has been steady for so long is steady.
inline constexpr double kSteady_s = 0.1;

/// [any] Which partial of a note a pitch is, within kNearPartial_cents; 0 if none.
int partial_of(double hertz, double expected_hz);

/// A tone at one moment of the tracker, beside the pitch expected at that time.
struct ToneMoment {
  double time_s = 0;
  double hertz = 0, expected_hz = 0;
  double rms = 0;

  double off_cents() const { return cents(hertz, expected_hz); }
};

/// [any] The moments of `track` from `from_s` to before `to_s`; `expected`: the pitch [Hz] at a time [s].
std::vector<ToneMoment> moments_between(const std::vector<PitchPoint>& track, double from_s, double to_s,
                                        const std::function<double(double)>& expected);

/// [any] The first moment from which on a tone is steady: for `hold_s` each moment has a pitch, within
/// kNearPartial_cents of how far off it ends, and a level within 15 dB of `rms`, what it ends as. `off_cents`
/// and `rms`: medians over what should be steady. nullopt: never. Source of the 15 dB: a tone is
/// heard to begin so far below its level, Vos & Rasch, Perception & Psychophysics 29, 1981.
std::optional<double> steady_from(const std::vector<ToneMoment>& moments, double off_cents, double rms,
                                  double hold_s = kSteady_s);

/// [any] How far a pitch swings [cents], the middle nine tenths of its moments.
double swing_of(std::vector<double> hertz);

}  // namespace tactus
