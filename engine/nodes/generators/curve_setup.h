#pragma once

// Thread: [control].

#include "engine/dsp/curves/curve.h"
#include "engine/graph/node_type.h"

namespace tactus {

Breakpoints::Shape curve_shape(const NodeSetup& setup);
/// The points of a `curve`, times in frames. Those within a millionth of a frame of a whole one become whole,
/// so that "3 ms" at 48 kHz is frame 144 and not a rounding error later.
Breakpoints::Points curve_points(const NodeSetup& setup);

}  // namespace tactus
