#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Sine generator.
const NodeType& sine_type();

}  // namespace tactus
