#pragma once

#include "engine/plot/plot.h"
#include "engine/study/sweep/sweep.h"

namespace tactus {

/// [any] A complete sweep as plots. One swept quantity: a line per measure. Two: a map per measure, the first
/// across; each combination of further ones has plots of its own, twelve at most. With draws: their measures
/// as points beside the scene as written.
std::vector<Plot> sweep_plots(const SweepTable& table);

}  // namespace tactus
