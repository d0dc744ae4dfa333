#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// A function given as a table of points.
const NodeType& map_type();

}  // namespace tactus
