#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Peak envelope follower.
const NodeType& envelope_type();

}  // namespace tactus
