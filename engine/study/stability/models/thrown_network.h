#pragma once

// Thread: [control].

#include "engine/nodes/networks/network.h"

namespace tactus {

/// Whether a network grows when it is played for itself: from its start, and with each of its masses thrown
/// at `kHardestStrike`, all velocities and the way from the start's positions times `factor`. It grows if in
/// 200,000 frames a mass comes to a hundred times the speed of the first tenth. `elements`: of the recipe, as
/// written.
bool grows_when_thrown(const NetworkRecipe& recipe, const NetworkElements& elements, double factor);

}  // namespace tactus
