#pragma once

#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "engine/graph/file/spec.h"
#include "engine/graph/node_type.h"

namespace tactus {

/// Every kind of node that a graph file can name. Filled by engine/nodes (`standard_nodes()`).
struct NodeTable {
  std::vector<const NodeType*> types;

  /// Turns one `[networks.x]` into the declaration of one node: its inputs are the fields of the elements
  /// that take signals ("coil.voltage"), its outputs what the elements can be asked for ("stick.position").
  /// Structural mistakes (unknown element types and keys, elements that do not exist) come back all at once.
  std::function<Checked<std::shared_ptr<const NodeType>>(const NetworkSpec&)> network;

  /// nullptr if there is no such type.
  const NodeType* find(std::string_view name) const;
};

}  // namespace tactus
