#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Counts triggers.
const NodeType& counter_type();

}  // namespace tactus
