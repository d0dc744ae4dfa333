#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Rounds to multiples of a step.
const NodeType& quantiser_type();

}  // namespace tactus
