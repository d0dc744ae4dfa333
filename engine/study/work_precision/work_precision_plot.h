#pragma once

#include "engine/plot/log_plot.h"
#include "engine/study/work_precision/work_precision.h"

namespace tactus {

/// [any] Error against computing time, a plot for each line of [accuracy]: a curve for each solver and rate
/// over its steps a frame, the front of what nothing beats, and where real time ends.
std::vector<LogPlot> plots_of(const WorkPrecision& study);

}  // namespace tactus
