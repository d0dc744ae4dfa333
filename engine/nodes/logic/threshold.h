#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Comparator with hysteresis: a level crossing becomes a trigger.
const NodeType& threshold_type();

}  // namespace tactus
