#pragma once
// Thread: [control]

#include <algorithm>
#include <functional>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/dsp/pitch/pitch_detector.h"
#include "engine/scene/play_scene.h"

namespace tactus {

// ---- a steady tone

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

/// [any] One number of each moment.
std::vector<double> each(const std::vector<ToneMoment>& moments, auto of) {
  std::vector<double> values;
  std::ranges::transform(moments, std::back_inserter(values), of);
  return values;
}

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

// ---- expected and detected notes

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
/// the instrument outputs, in the signal with the role "monitor".
struct Melody {
  const RecordedSignal* expected = nullptr;
  std::vector<PitchPoint> detected;
  std::vector<DetectedNote> notes;
};
/// [control] nullopt: the scene expects no pitch. Points into `recording`.
std::optional<Melody> melody_of(const SceneRecording& recording);

// ---- in words

/// [any] The nearest note, with what is over from 5 cents on: "A3", "A3 +50 cents".
std::string pitch_text(double hertz);

/// [any] "A2, 110.0 Hz: +0.3 cents, speaks after 0.12 s",
/// "from A2 to E3 in 0.80 s, 110.0 to 164.8 Hz: -4.0 cents".
std::string describe(const DetectedNote& note);
/// [any] "9 of 10 notes right and 1 of 1 glides, at most 0.4 cents off, each speaks within 0.21 s"
std::string describe(const std::vector<DetectedNote>& notes);

}  // namespace tactus
