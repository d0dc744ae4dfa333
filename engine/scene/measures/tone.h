#pragma once

#include "engine/scene/measures/judged_run.h"
#include "engine/scene/measures/notes/steady_tone.h"

namespace tactus {

/// The numbers of a tone; of several notes, those of the one with the least score.
struct ToneValues {
  double start_s = 0;  ///< from the beginning of the note to a steady tone
  int partial = 0;     ///< of the expected note, nearest to the tone; 0: none
  double cents = 0;    ///< over that partial, or over the note
  double right = 0;    ///< share of the moments with the expected note
  double level_spread = 0, swing_cents = 0, level = 0;
  int notes = 0, good_notes = 0;  ///< of all
};

/// It speaks at once.
inline constexpr double kPrompt_s = 0.25;
/// Its level is steady: standard deviation over mean, 2 dB.
inline constexpr double kSteadySpread = 0.25;

const std::vector<RunKind>& tone_kinds();

/// [control] A tone, looked at every 10 ms:
///     score = right * prompt * steady
/// right: the share of the moments that sound at the expected pitch, within kInTune_cents;
/// prompt: kPrompt_s over the time from `begin_s` until it is steady (see steady_from), at most 1; steady:
/// kSteadySpread over the spread of its level around the straight line through it, at most 1. Playable: the
/// right note in 9 of 10 moments, and the score at least kLeastScore.
///
/// Of several notes each is judged so from its own beginning on, `right` and `steady` from `from_s` -
/// `begin_s` later, at most from its middle; one shorter than 0.2 s is not judged. The score is the mean over
/// the notes; playable are they if each is; kind and readings are those of the weakest.
struct JudgedTone {
  JudgedRun run;
  ToneValues values;
};
JudgedTone tone_of(const SceneRecording& recording, const Playability& judged);

}  // namespace tactus
