#pragma once

#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// What one stream played and heard: frame n of `played` went out in the same block as frame n of `heard`
/// came in. So a loop of delay D frames brings played[n] at heard[.][n + D].
struct LoopRecording {
  Hertz sample_rate = 48_kHz;
  std::vector<double> played;              ///< behind the drive guard, full scale = 1
  std::vector<std::vector<double>> heard;  ///< every input channel
};

}  // namespace tactus
