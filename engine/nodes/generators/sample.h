#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Plays a sound file at each trigger.
const NodeType& sample_type();

}  // namespace tactus
