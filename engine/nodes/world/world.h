#pragma once

// Thread: [control]
#include <memory>

#include "engine/core/error.h"
#include "engine/graph/file/spec.h"
#include "engine/graph/node_type.h"

namespace tactus {

/// The declaration of the one node that `[worlds.x]` becomes: rigid bodies with contacts, stepped at the
/// world's own rate, a step every whole number of frames, so that the output does not depend on the block
/// size. Its inputs are the numbers and signals of the elements ("ball.x"), its outputs what they can be
/// asked for ("ball.z", "knock.hit"), and "energy", "depth" and "refused" of the whole. In the frames of a
/// step positions move on a line from one state to the next, which they reach with the next step: they jump
/// nowhere. What acts on the bodies acts with the step that follows. What elements there are:
/// `world_elements()`. Errors: those of `read_world_layout`; Missing in a build without ODE.
Checked<std::shared_ptr<const NodeType>> world_type(const NetworkSpec& spec);

}  // namespace tactus
