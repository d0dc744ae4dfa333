#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Limits a signal to a range.
const NodeType& clip_type();

}  // namespace tactus
