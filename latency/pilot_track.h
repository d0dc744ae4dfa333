#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/units.h"
#include "latency/bursts.h"
#include "latency/delay_trend.h"
#include "latency/path_model.h"

namespace tactus {

/// [control] The delay of the pilot, piece by piece: where 2048 frames of it, as the path would bring them,
/// are heard within 4096 frames of the delay `at`, to the frame. A piece that cannot be found is left out.
std::vector<DelayPoint> track_pilot(std::span<const double> played, std::span<const double> heard,
                                    const Burst& pilot, std::int64_t at, const PathModel& model,
                                    std::span<const double> profile);

}  // namespace tactus
