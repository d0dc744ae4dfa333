#pragma once

#include <cstdint>
#include <optional>

#include "latency/estimation/loop_estimator.h"

namespace tactus {

/// Another way by which what was played comes back, too far from the first one for the same window.
struct SecondPath {
  static constexpr std::int64_t kNear = 2048;  ///< frames: nearer ones are left to Response::echo
  std::int64_t frames = 0;                     ///< from the path to it; negative: it is earlier
  double level_db = 0.0;                       ///< beside the path
};

/// [control] Searches what is left of the recording once the path is taken away. It has to be captured of
/// most sweeps: where frames are lost, some are captured at one delay and the others at another.
std::optional<SecondPath> find_second_path(const LoopEstimate& loop, CoarseSearch& search);

}  // namespace tactus
