#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/dsp/pitch/pitch_detector.h"
#include "engine/scene/measures/notes/wanted_notes.h"
#include "engine/scene/play_scene.h"

namespace tactus {

/// What came of a note that was wanted. Each moment is held against the pitch wanted just then.
struct NoteHeard {
  WantedNote wanted;
  double heard_hz = 0;  ///< median of its second half; 0: nothing with a pitch
  int partial = 0;      ///< of the wanted pitch, nearest to what was heard; 0: nothing, or lower than that
  double cents = 0;     ///< heard over that partial, median of the second half
  std::optional<double> speaks_after_s;  ///< until it stands (see stands_at), or half of it if it is short
  double swing_cents = 0;                ///< of what was heard since it stands, see swing_of
  double wanted_swing_cents = 0;         ///< of what was wanted then
  std::optional<double> swings_hz;       ///< how often it swings, where that is a vibrato's 3 Hz to 10 Hz
  double partials_s = 0;                 ///< how long another partial was heard
  int other_partial = 0;                 ///< which one for the longest
  double strays_s = 0;                   ///< how long a pitch was heard that is no partial
  double silent_s = 0;                   ///< how long no pitch was heard after it stood

  /// It ends on its first partial, within kInTune_cents, and was elsewhere for at most a quarter of its time.
  bool right() const;
};

/// [control] What was heard of the notes that were wanted in each frame (0: none).
std::vector<NoteHeard> notes_heard(const std::vector<PitchPoint>& track, std::span<const double> wanted_hz,
                                   Hertz rate);

/// [control] Pitch of a sound in which notes between two pitches are wanted: from an octave below the lowest
/// to the third partial of the highest, or the sixth of the lowest.
std::vector<PitchPoint> track_notes(std::span<const double> sound, Hertz rate, Hertz lowest, Hertz highest);
/// [any] The lowest pitch that `track_notes` looks for.
Hertz lowest_tracked(Hertz lowest);

/// What a scene was to play and what was heard of it: the notes of a signal in Hz, which a part other than
/// the instrument gives out, in the signal with the role "monitor".
struct Melody {
  const RecordedSignal* wanted = nullptr;
  std::vector<PitchPoint> heard;
  std::vector<NoteHeard> notes;
};
/// [control] nullopt: the scene wants no pitch. Points into `recording`.
std::optional<Melody> melody_of(const SceneRecording& recording);

}  // namespace tactus
