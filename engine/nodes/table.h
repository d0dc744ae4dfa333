#pragma once

#include "engine/graph/node_type.h"

namespace tactus {

/// [any] Every node type that comes with Tactus, by family.
const NodeTable& standard_nodes();

}  // namespace tactus
