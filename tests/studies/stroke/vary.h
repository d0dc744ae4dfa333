#pragma once

#include <vector>

#include "tests/studies/onset/random.h"

namespace tactus::study {

/// A take of two recordings in turn (or one, twice) for training, as a microphone on another drum may pick it
/// up. Drawn for each take, each with a probability of its own: pitch within 3 semitones; tilt of the
/// spectrum within 9 dB; a rattle after each stroke, a noise that rises by 3 to 6 dB until 20 to 80 ms after
/// it, rough as the buzz of snares is; modes that ring on; strokes at irregular times; rests of 0.4 to 1.5 s;
/// thumps below 120 Hz; hum; coloured noise; saturation; a level down to -30 dBFS. Appends the onsets; sets
/// the audio.
void vary(Random& random, const std::vector<float>& first, const std::vector<float>& second, double take_s,
          std::vector<double>& strokes_s, std::vector<float>& audio);

}  // namespace tactus::study
