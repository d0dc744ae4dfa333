#pragma once

#include <string>
#include <vector>

#include "engine/scene/measures/measure.h"

// Thread: [control]

namespace tactus {

/// How playable the instrument was in one run of a scene; docs/playability.md explains the rules.
struct PlayabilityResult {
  std::string kind;  ///< one of `run_kinds`
  double score = 0;  ///< 0 nothing, 1 all that is expected
  bool playable = false;
  std::vector<double> readings;  ///< in the order of `measure_columns`; all finite
  bool operator==(const PlayabilityResult&) const = default;
};

/// A measure in the tables, plots and JSON of a playability study.
struct MeasureColumn {
  std::string name;  ///< in JSON: "rate_hz"
  std::string head;  ///< "hits/s"
  int digits;        ///< behind the point
  std::string measure;
  bool drawn = false;  ///< over the delay
};
/// All columns of a roll, or of a tone.
const std::vector<MeasureColumn>& measure_columns(Playability::Kind kind);
/// The readings of a window, whose `playability` is given.
std::vector<double> readings_of(const Window& window);

/// What a run can turn out to be, from best to worst.
struct RunKind {
  std::string name;  ///< "gallop"
  char letter;       ///< on a map of characters
  std::string doc;
};
const std::vector<RunKind>& run_kinds(Playability::Kind kind);

/// Evaluates what was recorded in the window of `playability`.
///
/// A deviation x from what is expected counts as
///     near(x, half) = 1 / (1 + (x / half)^2),
/// which never stops rewarding less of it; `half` is where it counts half (the constants below).
///
/// A roll. Only detected strikes count that the contact has: a drum that detects its own excitation does not
/// play.
///     score = sustained * detected * rhythm * loudness * rate
/// sustained: the share of the windows of 1 s, every 0.1 s, that have `fewest` strikes;
/// detected: strikes that were detected once over those, the missed and the doubled ones;
/// rhythm: of what `roll` asks for, with the spread s_1 and the best pattern s_p (see Evenness):
///     even       near(s_1, kHalfSpread)
///     any        near(s_p, kHalfSpread)
///     gallop     near(s_p, kHalfSpread) (1 - near(ln(long / short), ln kHalfRatio))
///     backwards  min(1, growing intervals in a row / kFewestGrowing)^2
/// loudness: near(peaks of the strikes [dB] as s_p of their pattern, kHalfLoudness_db); backwards: 1;
/// rate: near(ln(rate / wanted), ln kHalfRate), where one is wanted.
/// Playable: every second has `fewest`, and the score is at least kLeastScore.
///
/// A tone, measured every 10 ms.
///     score = in_tune * prompt * steady * clean
/// in_tune: mean of near(cents off the expected pitch, kHalfCents) over all moments, 0 where another partial,
/// another pitch or none sounds; prompt: near(time from `begin_s` until it is steady (see steady_from),
/// kHalfStart_s); steady: near(spread of its level around the straight line through it, kHalfUnsteady);
/// clean: near(noise share of its first kOnset_s, kHalfNoise). Playable: the right note in 9 of 10 moments,
/// and the score at least kLeastScore.
///
/// Each of several notes is evaluated from its own beginning on, all but `prompt` and `clean` from `from_s` -
/// `begin_s` later, at most from its middle; one shorter than 0.2 s is left out. The score is the mean over
/// the notes times near(standard deviation of their levels [dB], kHalfLevel_db); they are playable if each
/// is; kind and readings are those of the worst.
PlayabilityResult evaluate(const SceneRecording& recording, const Playability& playability);

/// How even the intervals between strikes are. The spread of a pattern of p strikes is
///     s_p = rms(I[n + p] - I[n]) / (sqrt(2) mean(I)):
/// 0 where every p-th interval repeats, the standard deviation over the mean where nothing does.
struct Evenness {
  double spread = 0;          ///< standard deviation of the intervals over their mean
  int beats = 1;              ///< p <= 4 of the smallest s_p; the first one below 0.02, if there is
  double pattern_spread = 0;  ///< that s_p
};
/// Of at least six times in rising order; a spread of 1 where there are fewer.
Evenness evenness_of(const std::vector<double>& times_s);

/// Likewise of the peaks of strikes in a force [dB], over patterns of `beats` strikes; 0 of too few.
double loudness_spread(const std::vector<Strike>& strikes, int beats);

/// Share of the windows of a second, every 0.1 s, with at least `fewest` of these times, which rise.
double sustained(const std::vector<double>& times_s, double from_s, double to_s, double fewest);

/// A roll that is perceived as even: 6 ms of the 40 ms between two strikes of a roll of 25 a second. Source:
/// Friberg & Sundberg, "Time discrimination in a monotonic, isochronous sequence", JASA 98, 1995.
inline constexpr double kEvenSpread = 0.15;
/// The least score of a playable run.
inline constexpr double kLeastScore = 0.5;

// Deviations that count half, see `evaluate`. Listeners notice a third of the spread (kEvenSpread is heard in
// most rolls), a quarter of the ratio and half of the cents; the others are the program's own.
inline constexpr double kHalfSpread = 0.2, kHalfRatio = 1.25, kHalfRate = 1.15, kHalfLoudness_db = 6;
inline constexpr double kHalfCents = 50, kHalfStart_s = 0.5, kHalfUnsteady = 0.5, kHalfNoise = 0.3,
                        kHalfLevel_db = 6;
inline constexpr int kFewestGrowing = 6;
inline constexpr double kOnset_s = 0.3;
/// [any] 1 at 0, and half at `half`.
inline double near(double deviation, double half) {
  return 1 / (1 + (deviation / half) * (deviation / half));
}

/// The numbers of a tone; of several notes, those of the one with the least score.
struct ToneValues {
  double start_s = 0;  ///< from the beginning of the note to a steady tone
  int partial = 0;     ///< of the expected note, nearest to the tone; 0: none
  double cents = 0;    ///< over that partial, or over the note
  double right = 0;    ///< share of the moments with the expected note
  double in_tune = 0;  ///< see `evaluate`
  double level_spread = 0, swing_cents = 0, level = 0;
  double onset_noise = 0;         ///< share of what does not repeat after a period, in the first kOnset_s
  double level_deviation_db = 0;  ///< of the notes from each other
  int notes = 0, good_notes = 0;  ///< of all
};

struct ToneResult {
  PlayabilityResult run;
  ToneValues values;
};
ToneResult tone_of(const SceneRecording& recording, const Playability& playability);

}  // namespace tactus
