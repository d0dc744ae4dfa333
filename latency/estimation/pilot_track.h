#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/units.h"
#include "latency/estimation/delay_trend.h"
#include "latency/path/path_model.h"
#include "latency/probe/bursts.h"

namespace tactus {

/// What was captured of the pilot.
struct PilotTrack {
  std::vector<DelayPoint> points;  ///< of each piece that was recorded and found
  double least_step = 0.0;         ///< frames: less may be noise, or a path that the model does not know well
  std::vector<std::int64_t>
      damage;  ///< frames of the recording where for a moment something else is captured
};

/// [control] Piece by piece: where 2048 frames of it, as the path would bring them, are captured within 4096
/// frames of the delay `at`, to the frame. `variance`: of a frame of noise.
PilotTrack track_pilot(std::span<const double> played, std::span<const double> captured, const Burst& pilot,
                       std::int64_t at, const PathModel& model, std::span<const double> profile,
                       double variance);

}  // namespace tactus
