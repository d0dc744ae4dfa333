#pragma once

#include "engine/graph/node_table.h"

namespace tactus {

/// Every node type that comes with Tactus. A new node is its own files and one line in table.cpp.
const NodeTable& standard_nodes();

}  // namespace tactus
