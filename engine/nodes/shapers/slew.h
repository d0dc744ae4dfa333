#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Follows a signal no faster than a given rate.
const NodeType& slew_type();

}  // namespace tactus
