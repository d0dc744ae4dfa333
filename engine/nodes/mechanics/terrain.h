#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// Detents and textures from a profile of heights.
const NodeType& terrain_type();

}  // namespace tactus
