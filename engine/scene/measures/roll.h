#pragma once

#include "engine/scene/measures/judged_run.h"

namespace tactus {

/// How even the intervals between strikes are. The spread of a pattern of p strikes is
///     s_p = rms(I[n + p] - I[n]) / (sqrt(2) mean(I)):
/// 0 where every p-th interval repeats, the standard deviation over the mean where nothing does.
struct Evenness {
  double spread = 0;          ///< standard deviation of the intervals over their mean
  int beats = 1;              ///< p <= 4 of the smallest s_p; the first one below 0.02, if there is
  double pattern_spread = 0;  ///< that s_p
};
/// [any] Of at least six times in rising order; a spread of 1 where there are fewer.
Evenness evenness_of(const std::vector<double>& times_s);

/// [any] Share of the windows of a second, every 0.1 s, with at least `fewest` of these times, which rise.
double sustained(const std::vector<double>& times_s, double from_s, double to_s, double fewest);

/// A roll that is perceived as even: 6 ms of the 40 ms between two strikes of a roll of 25 a second. Source:
/// Friberg & Sundberg, "Time discrimination in a monotonic, isochronous sequence", JASA 98, 1995.
inline constexpr double kEvenSpread = 0.15;
/// What a run must have to be an instrument.
inline constexpr double kLeastScore = 0.5;

const std::vector<RunKind>& roll_kinds();

/// [control] A roll. Only detected strikes count that the contact has: a drum that detects its own throws
/// does not play.
///     score = sustained * detected * even
/// sustained: the share of the windows of 1 s, every 0.1 s, that have `fewest` strikes;
/// detected: strikes that were detected once over those, the missed and the doubled ones;
/// even: kEvenSpread over the spread of its best pattern, at most 1.
/// Playable: every second has `fewest`, and the score is at least kLeastScore.
JudgedRun judge_roll(const SceneRecording& recording, const Playability& judged);

}  // namespace tactus
