#pragma once

#include <string>

// Thread: [any]

namespace tactus {

/// Semitones of A4 above C0, and of an octave.
inline constexpr int kA4 = 57, kSemitonesOfOctave = 12;

/// The nearest note of the scale in equal temperament, in semitones above C0; A4 = 440 Hz is 57.
int nearest_note(double hertz);
/// Its frequency in Hz: 440 * 2^((semitones - 57) / 12).
double pitch_of_note(int semitones);
/// Semitones above the C below; the note may lie below C0.
int semitones_above_c(int semitones);
/// "A2", "C#4": the nearest note.
std::string note_name(double hertz);

}  // namespace tactus
