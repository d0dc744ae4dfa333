#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Virtual wall: a spring and damper that can only push.
const NodeType& wall_type();

}  // namespace tactus
