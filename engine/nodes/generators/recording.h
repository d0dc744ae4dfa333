#pragma once

// Thread: [control].

#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/core/units.h"

namespace tactus {

/// One channel of a recording, full scale = 1.
struct Recording {
  std::vector<double> samples;
  Hertz sample_rate;
};

/// Reads channel number `channel` (1 is the first) of a sound file of any kind that libsndfile knows. Errors:
/// BadFile (missing, not a sound file, not finite), OutOfRange (the file has fewer channels).
Result<Recording> read_recording(const std::string& path, int channel);

}  // namespace tactus
