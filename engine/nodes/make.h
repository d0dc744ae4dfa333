#pragma once

#include <memory>

#include "engine/graph/node_type.h"

namespace tactus {

/// `make` of a node type whose class is constructed from the setup and cannot fail.
template <class SomeNode>
Result<std::unique_ptr<Node>> make_node(const NodeSetup& setup) {
  return std::make_unique<SomeNode>(setup);
}

}  // namespace tactus
