#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/dsp/pitch_track.h"
#include "engine/scene/play_scene.h"

namespace tactus {

/// What came of a note that was wanted.
struct NoteHeard {
  double from_s = 0, to_s = 0;
  double wanted_hz = 0;  ///< median
  double heard_hz = 0;   ///< median of its second half; 0: nothing with a pitch
  int partial = 0;   ///< of the wanted note, nearest to what was heard; 0: nothing, or lower than the note
  double cents = 0;  ///< heard over that partial
  double swing_cents = 0;                ///< from the lowest to the highest in its second half
  std::optional<double> speaks_after_s;  ///< until it is within 50 cents of what it ends as
};

/// [control] The notes in a track, held against the pitch that was wanted in each frame (0: none). A new one
/// starts where that jumps by more than half a semitone; one shorter than 50 ms is none.
std::vector<NoteHeard> notes_heard(const std::vector<PitchPoint>& track, std::span<const double> wanted_hz,
                                   Hertz rate);

/// What a scene was to play and what was heard of it: the notes of a signal in Hz, which a part other than
/// the instrument gives out, in the output `sound` of the instrument.
struct Melody {
  const RecordedSignal* wanted = nullptr;
  std::vector<PitchPoint> heard;
  std::vector<NoteHeard> notes;
};
/// [control] nullopt: the scene wants no pitch. Points into `recording`.
std::optional<Melody> melody_of(const SceneRecording& recording);

/// [any] "A2", "C#4": the nearest note of the scale in equal temperament, A4 = 440 Hz.
std::string note_name(double hertz);

/// [any] "A2, 110.0 Hz: +0.3 cents, speaks after 0.12 s"
std::string in_words(const NoteHeard& note);
/// [any] "10 of 10 notes on their first partial, at most 0.4 cents off, within 0.21 s"
std::string in_words(const std::vector<NoteHeard>& notes);

}  // namespace tactus
