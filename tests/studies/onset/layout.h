#pragma once

#include <string>
#include <vector>

#include "tests/studies/onset/samples.h"

namespace tactus::study {

struct TrueHit {
  double time_s = 0;    ///< of the onset of the clean hit
  double level_db = 0;  ///< its largest frame, re full scale
  bool fast = false;    ///< rises in less than 1 ms
  bool training = false;
  std::string kind, sample, pattern, noise;
  double rate = 0;     ///< hits a second around it
  bool rings = false;  ///< falls by less than 6 dB in one interval: hidden in its own ringing
};

/// What one file is made of: the same pattern, noise and sensitivity throughout, sections of one drum each
/// (`mixed`: another drum each hit), rate and level changing from section to section.
struct Plan {
  std::string name;
  std::string pattern;  ///< steady, mixed, accent_12, accent_20, crescendo, flam
  std::string noise;    ///< none, white_60, white_50, hum
  std::vector<double> rates, levels_db;
  double threshold_db = -34;
};

struct Layout {
  std::vector<float> audio;
  std::vector<TrueHit> hits;
};

/// Every file of the study.
std::vector<Plan> all_plans();

/// The same bits each time: every random number comes from a generator seeded with the plan's name.
Layout lay_out(const Plan& plan, const SampleSet& set);

}  // namespace tactus::study
