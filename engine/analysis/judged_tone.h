#pragma once

#include "engine/analysis/judged_run.h"

namespace tactus {

/// A note is right within a quarter of a semitone, where singers begin to call it wrong. Source: Vurma &
/// Ross, "Production and perception of musical intervals", Music Perception 23, 2006.
inline constexpr double kInTune_cents = 25;
/// It speaks at once.
inline constexpr double kPrompt_s = 0.25;
/// Its level stands: standard deviation over mean, 2 dB.
inline constexpr double kSteadySpread = 0.25;

const std::vector<ReadingType>& tone_readings();
const std::vector<RunKind>& tone_kinds();

/// [control] A tone, looked at every 10 ms:
///     score = right * prompt * steady
/// right: the share of the moments that sound at the pitch wanted, within kInTune_cents;
/// prompt: kPrompt_s over the time from `begin_s` until it stands (for 0.1 s within 50 cents and 15 dB of
/// what it ends as), at most 1; steady: kSteadySpread over the spread of its level, at most 1. Playable: the
/// right note in 9 of 10 moments, and the score at least kLeastScore.
JudgedRun judge_tone(const SceneRecording& recording, const Playability& judged);

}  // namespace tactus
