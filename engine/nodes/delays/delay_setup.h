#pragma once

// Thread: [control].

#include "engine/dsp/delays/taps_kernel.h"
#include "engine/graph/node_type.h"

namespace tactus {

/// The times that a `delay` can have. Errors: UnitMismatch, OutOfRange.
Result<tactus_delay> delay_range(const NodeSetup& setup);
/// Of its interpolation: 0, 1, 3 or 5.
int delay_order(const NodeSetup& setup);

}  // namespace tactus
