#pragma once

#include <cmath>
#include <string>

// Thread: [any]

namespace tactus {

/// Semitones of A4 above C0, and of an octave.
inline constexpr int kA4 = 57, kSemitonesOfOctave = 12;

/// The nearest note of the scale in equal temperament, in semitones above C0; A4 = 440 Hz is 57.
inline int nearest_note(double hertz) {
  return static_cast<int>(std::lround(kA4 + kSemitonesOfOctave * std::log2(hertz / 440)));
}
/// Its frequency in Hz: 440 * 2^((semitones - 57) / 12).
inline double pitch_of_note(int semitones) {
  return 440 * std::exp2(static_cast<double>(semitones - kA4) / kSemitonesOfOctave);
}
/// Semitones above the C below; the note may lie below C0.
inline int semitones_above_c(int semitones) {
  return (semitones % kSemitonesOfOctave + kSemitonesOfOctave) % kSemitonesOfOctave;
}
/// "A2", "C#4": the nearest note.
inline std::string note_name(double hertz) {
  static constexpr const char* kNames[] = {"C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B"};
  const int note = nearest_note(hertz), step = semitones_above_c(note);
  return kNames[step] + std::to_string((note - step) / kSemitonesOfOctave);
}

}  // namespace tactus
