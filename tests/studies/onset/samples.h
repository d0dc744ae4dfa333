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
/// Electronic: the drums of kits that are no recordings of an acoustic kit.
enum class Recordings { Acoustic, Electronic };
/// `kits`: of these only; all of them if there are none.
SampleSet load_samples(Recordings recordings = Recordings::Acoustic,
                       const std::vector<std::string>& kits = {});

/// The recordings FOLDER/KIND/FILE of a kit; their names start with the folder's name. Without `training`.
SampleSet load_kit(const std::string& folder);

}  // namespace tactus::study
