#pragma once

#include <string>
#include <vector>

#include "engine/scene/measures/notes/pitch_track.h"

namespace tactus {

/// [any] The nearest note, with what is over from 5 cents on: "A3", "A3 +50 cents".
std::string pitch_text(double hertz);

/// [any] "A2, 110.0 Hz: +0.3 cents, speaks after 0.12 s",
/// "from A2 to E3 in 0.80 s, 110.0 to 164.8 Hz: -4.0 cents".
std::string describe(const DetectedNote& note);
/// [any] "9 of 10 notes right and 1 of 1 glides, at most 0.4 cents off, each speaks within 0.21 s"
std::string describe(const std::vector<DetectedNote>& notes);

}  // namespace tactus
