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
/// A roll. Only detected strikes count that the contact has: a drum that detects its own excitation does not
/// play.
///     score = sustained * detected * even
/// sustained: the share of the windows of 1 s, every 0.1 s, that have `fewest` strikes;
/// detected: strikes that were detected once over those, the missed and the doubled ones;
/// even: kEvenSpread over the spread of its best pattern, at most 1.
/// Playable: every second has `fewest`, and the score is at least kLeastScore.
///
/// A tone, measured every 10 ms.
///     score = right * prompt * steady
/// right: the share of the moments that sound at the expected pitch, within kInTune_cents;
/// prompt: kPrompt_s over the time from `begin_s` until it is steady (see steady_from), at most 1; steady:
/// kSteadySpread over the spread of its level around the straight line through it, at most 1. Playable: the
/// right note in 9 of 10 moments, and the score at least kLeastScore.
///
/// Each of several notes is evaluated from its own beginning on, `right` and `steady` from `from_s` -
/// `begin_s` later, at most from its middle; one shorter than 0.2 s is left out. The score is the mean over
/// the notes; they are playable if each is; kind and readings are those of the worst.
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

/// Share of the windows of a second, every 0.1 s, with at least `fewest` of these times, which rise.
double sustained(const std::vector<double>& times_s, double from_s, double to_s, double fewest);

/// A roll that is perceived as even: 6 ms of the 40 ms between two strikes of a roll of 25 a second. Source:
/// Friberg & Sundberg, "Time discrimination in a monotonic, isochronous sequence", JASA 98, 1995.
inline constexpr double kEvenSpread = 0.15;
/// The least score of a playable run.
inline constexpr double kLeastScore = 0.5;

/// It speaks at once.
inline constexpr double kPrompt_s = 0.25;
/// Its level is steady: standard deviation over mean, 2 dB.
inline constexpr double kSteadySpread = 0.25;

/// The numbers of a tone; of several notes, those of the one with the least score.
struct ToneValues {
  double start_s = 0;  ///< from the beginning of the note to a steady tone
  int partial = 0;     ///< of the expected note, nearest to the tone; 0: none
  double cents = 0;    ///< over that partial, or over the note
  double right = 0;    ///< share of the moments with the expected note
  double level_spread = 0, swing_cents = 0, level = 0;
  int notes = 0, good_notes = 0;  ///< of all
};

struct ToneResult {
  PlayabilityResult run;
  ToneValues values;
};
ToneResult tone_of(const SceneRecording& recording, const Playability& playability);

}  // namespace tactus
