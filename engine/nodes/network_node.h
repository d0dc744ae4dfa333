#pragma once

#include <memory>

#include "engine/graph/node.h"
#include "engine/graph/node_type.h"
#include "engine/nodes/network_layout.h"

namespace tactus {

/// [control] The running node of a network: outputs at frame n are the state at n, inputs act from n to n
/// + 1.
Result<std::unique_ptr<Node>> make_network_node(const NetworkLayout& layout, const NodeSetup& setup);

}  // namespace tactus
