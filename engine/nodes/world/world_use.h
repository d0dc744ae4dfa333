#pragma once

// Thread: [control]
#include <vector>

#include "engine/graph/node_type.h"
#include "engine/nodes/world/world_layout.h"

namespace tactus {

/// Which elements of a world matter to the outputs that are read; by element.
struct WorldUse {
  std::vector<bool> absent, kept;
};

WorldUse find_used(const WorldLayout& layout, const NodeSetup& setup);

}  // namespace tactus
