#pragma once

#include <string>
#include <vector>

#include "engine/plot/svg_scale.h"

namespace tactus {

/// [any] The note nearest to a pitch, in semitones above C0; A4 = 440 Hz is 57.
int nearest_note(double hertz);
/// [any] Its pitch in equal temperament.
double pitch_of_note(int semitones);
/// [any] "A2", "C#4": the nearest note of the scale.
std::string note_name(double hertz);

namespace svg {

/// Ticks of an axis of pitch, "A3 220 Hz": as many notes of each octave as leave at most `most`, or else
/// every second, third, ... A.
std::vector<Tick> note_ticks(const Scale& scale, int most);

}  // namespace svg
}  // namespace tactus
