#include "engine/core/notes.h"

#include <array>
#include <cmath>

namespace tactus {

int semitones_above_c(int semitones) {
  return (semitones % kSemitonesOfOctave + kSemitonesOfOctave) % kSemitonesOfOctave;
}

int nearest_note(double hertz) {
  return static_cast<int>(std::lround(kA4 + kSemitonesOfOctave * std::log2(hertz / 440)));
}

double pitch_of_note(int semitones) {
  return 440 * std::exp2(static_cast<double>(semitones - kA4) / kSemitonesOfOctave);
}

std::string note_name(double hertz) {
  static constexpr std::array<const char*, 12> kNames = {"C",  "C#", "D",  "D#", "E",  "F",
                                                         "F#", "G",  "G#", "A",  "A#", "B"};
  const int note = nearest_note(hertz), step = semitones_above_c(note);
  return kNames[static_cast<std::size_t>(step)] + std::to_string((note - step) / kSemitonesOfOctave);
}

}  // namespace tactus
