#pragma once

#include <array>
#include <string>
#include <vector>

#include "tests/studies/onset/clean_hit.h"

namespace tactus::study {

inline constexpr double kRate = 48000;
inline constexpr int kShifts = 4;

/// One recorded hit: mono, 48 kHz, largest frame 1, at most 0.7 s.
struct Sample {
  std::string name, kind;
  bool training = false;
  std::array<std::vector<float>, kShifts> shifted;  ///< starting 0, 1/4, 1/2 and 3/4 of a frame late
  std::array<CleanHit, kShifts> clean;
};

struct SampleSet {
  std::vector<Sample> samples;
  std::vector<std::string> excluded;  ///< "name: rule"
};

/// Every acoustic drum hit (by kit and file name: snare, tom, kick, rim, hat, hand, wood) of Debian's
/// packages hydrogen-drumkits and sonic-pi-samples. Every second of each kind is for training.
SampleSet load_samples();

}  // namespace tactus::study
