#pragma once

#include "engine/plot/plot.h"
#include "engine/study/work_precision/work_precision.h"

namespace tactus {

/// [any] Error against computing time, a plot for each line of [accuracy]: a curve for each solver and rate
/// over its oversampling, the Pareto front, and the limit of real time.
std::vector<Plot> plots_of(const WorkPrecision& study);

}  // namespace tactus
