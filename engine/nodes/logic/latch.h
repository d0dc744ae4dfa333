#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Remembers which of two triggers came last.
const NodeType& latch_type();

}  // namespace tactus
