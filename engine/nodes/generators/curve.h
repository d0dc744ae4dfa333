#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Breakpoint curve over time.
const NodeType& curve_type();

}  // namespace tactus
