#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/dsp/pitch/pitch_detector.h"
#include "engine/scene/play_scene.h"

namespace tactus {

/// A note that is to be played, or a glide from one to another.
struct ExpectedNote {
  double from_s = 0, to_s = 0;
  double begins_hz = 0, ends_hz = 0;
  double hertz = 0;  ///< median
  bool glides = false;

  double seconds() const { return to_s - from_s; }
};

/// [any] The notes in a pitch that is expected in each frame (0: none). It steps to the next one where it
/// jumps by more than 5 cents from one frame to the next. In between it glides where it rises or falls by
/// more than half a semitone and does not swing back at once, as a vibrato does: a swing moves by at most 300
/// cents, in a quarter of a second. What is shorter than 50 ms is no note, nor 0.1 s a glide.
std::vector<ExpectedNote> expected_notes(std::span<const double> expected_hz, Hertz rate);

/// A detected note beside the expected one. Each moment is compared with the pitch expected at that time.
struct DetectedNote {
  ExpectedNote expected;
  double detected_hz = 0;  ///< median of its second half; 0: nothing with a pitch
  int partial = 0;   ///< of the expected pitch, nearest to the detected one; 0: none, or lower than that
  double cents = 0;  ///< detected pitch over that partial, median of the second half
  std::optional<double>
      speaks_after_s;                ///< until it is steady (see steady_from), or half of it if it is short
  double swing_cents = 0;            ///< of the detected pitch since it is steady, see swing_of
  double expected_swing_cents = 0;   ///< of the expected pitch then
  std::optional<double> vibrato_hz;  ///< how often it swings, where that is a vibrato's 3 Hz to 10 Hz
  double partials_s = 0;             ///< time on another partial
  int other_partial = 0;             ///< which one for the longest
  double strays_s = 0;               ///< time on a pitch that is no partial
  double silent_s = 0;               ///< time without a pitch after it was steady

  /// It ends on its first partial, within kInTune_cents, and was elsewhere for at most a quarter of its time.
  bool right() const;
};

/// [control] Detects the notes that are expected in each frame (0: none).
std::vector<DetectedNote> detect_notes(const std::vector<PitchPoint>& track,
                                       std::span<const double> expected_hz, Hertz rate);

/// [control] Pitch of a sound in which notes between two pitches are expected: from an octave below the
/// lowest to the third partial of the highest, or the sixth of the lowest.
std::vector<PitchPoint> track_notes(std::span<const double> sound, Hertz rate, Hertz lowest, Hertz highest);
/// [any] The lowest pitch that `track_notes` looks for.
Hertz lowest_tracked(Hertz lowest);

/// The expected and the detected notes of a scene: those of a signal in Hz, which a part other than
/// the instrument gives out, in the signal with the role "monitor".
struct Melody {
  const RecordedSignal* expected = nullptr;
  std::vector<PitchPoint> detected;
  std::vector<DetectedNote> notes;
};
/// [control] nullopt: the scene expects no pitch. Points into `recording`.
std::optional<Melody> melody_of(const SceneRecording& recording);

}  // namespace tactus
