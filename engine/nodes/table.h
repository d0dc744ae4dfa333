#pragma once

#include "engine/graph/node_type.h"

// Thread: [control].

namespace tactus {

/// [any] Every node type that comes with Tactus, by family.
const NodeTable& standard_nodes();

/// [any] A finite impulse response, which measured paths of scenes are.
NodeType fir_type();

}  // namespace tactus
