#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Exponentially decaying pulse at each trigger.
const NodeType& decay_type();

}  // namespace tactus
