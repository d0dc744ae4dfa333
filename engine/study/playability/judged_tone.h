#pragma once

#include "engine/study/notes/standing_tone.h"
#include "engine/study/playability/judged_run.h"

namespace tactus {

/// It speaks at once.
inline constexpr double kPrompt_s = 0.25;
/// Its level stands: standard deviation over mean, 2 dB.
inline constexpr double kSteadySpread = 0.25;

const std::vector<ReadingType>& tone_readings();
const std::vector<RunKind>& tone_kinds();

/// [control] A tone, looked at every 10 ms:
///     score = right * prompt * steady
/// right: the share of the moments that sound at the pitch wanted, within kInTune_cents;
/// prompt: kPrompt_s over the time from `begin_s` until it stands (see stands_at), at most 1; steady:
/// kSteadySpread over the spread of its level around the straight line through it, at most 1. Playable: the
/// right note in 9 of 10 moments, and the score at least kLeastScore.
///
/// Of several notes each is judged so from its own beginning on, `right` and `steady` from `from_s` -
/// `begin_s` later, at most from its middle; one shorter than 0.2 s is not judged. The score is the mean over
/// the notes; playable are they if each is; kind and readings are those of the weakest.
JudgedRun judge_tone(const SceneRecording& recording, const Playability& judged);

}  // namespace tactus
