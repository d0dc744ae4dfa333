#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Keeps the value that its input had at the last trigger.
const NodeType& sample_hold_type();

}  // namespace tactus
