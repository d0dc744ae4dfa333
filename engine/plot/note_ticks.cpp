#include "engine/plot/note_ticks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace tactus {
namespace {

constexpr int kA4 = 57;
constexpr int kOctave = 12;

/// Of a note that may lie below C0.
int above_c(int semitones) { return (semitones % kOctave + kOctave) % kOctave; }

/// The notes between two ends that `wanted` takes.
template <class Wanted>
std::vector<int> notes_in(int low, int high, Wanted wanted) {
  std::vector<int> notes;
  for (int note = low; note <= high; ++note)
    if (wanted(note)) notes.push_back(note);
  return notes;
}

std::vector<int> ticked_notes(int low, int high, std::size_t most) {
  // Of an octave from C on: all, those without a sharp, C E A, E A.
  for (const std::string_view octave : {"xxxxxxxxxxxx", "x.x.xx.x.x.x", "x...x....x..", "....x....x.."}) {
    auto notes =
        notes_in(low, high, [&](int n) { return octave[static_cast<std::size_t>(above_c(n))] == 'x'; });
    if (notes.size() <= most) return notes;
  }
  for (int octaves = 1;; ++octaves) {
    auto notes = notes_in(low, high, [&](int n) { return (n - kA4) % (octaves * kOctave) == 0; });
    if (notes.size() <= std::max<std::size_t>(1, most)) return notes;
  }
}

}  // namespace

int nearest_note(double hertz) {
  return static_cast<int>(std::lround(kA4 + kOctave * std::log2(hertz / 440)));
}

double pitch_of_note(int semitones) {
  return 440 * std::exp2(static_cast<double>(semitones - kA4) / kOctave);
}

std::string note_name(double hertz) {
  static constexpr std::array<const char*, 12> kNames = {"C",  "C#", "D",  "D#", "E",  "F",
                                                         "F#", "G",  "G#", "A",  "A#", "B"};
  const int note = nearest_note(hertz), step = above_c(note);
  return kNames[static_cast<std::size_t>(step)] + std::to_string((note - step) / kOctave);
}

namespace svg {

std::vector<Tick> note_ticks(const Scale& scale, int most) {
  std::vector<Tick> ticks;
  const auto low = kA4 + kOctave * std::log2(scale.low / 440),
             high = kA4 + kOctave * std::log2(scale.high / 440);
  for (const int note :
       ticked_notes(static_cast<int>(std::ceil(low - 1e-9)), static_cast<int>(std::floor(high + 1e-9)),
                    static_cast<std::size_t>(std::max(0, most)))) {
    const double hertz = pitch_of_note(note);
    ticks.push_back({hertz, fmt::format("{} {:.0f} Hz", note_name(hertz), hertz)});
  }
  return ticks;
}

}  // namespace svg
}  // namespace tactus
