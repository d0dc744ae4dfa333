#pragma once

#include <cmath>

#include "engine/core/units.h"

namespace tactus {

/// What an exponential keeps in one frame:  keep = e^(-1 / (sample_rate * tau)); 0 for tau <= 0, which is "at
/// once".
class TimeConstant {
 public:
  explicit TimeConstant(Hertz sample_rate) : sample_rate_(sample_rate.value) {}

  /// [realtime] Computed only when `seconds` changes, so it may be asked every frame.
  double keep(double seconds) {
    if (seconds != seconds_) {
      seconds_ = seconds;
      keep_ = seconds > 0 ? std::exp(-1.0 / (sample_rate_ * seconds)) : 0.0;
    }
    return keep_;
  }

 private:
  double sample_rate_;
  double seconds_ = 0;
  double keep_ = 0;
};

}  // namespace tactus
