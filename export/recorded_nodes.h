#pragma once

// Thread: [control].

#include <map>
#include <memory>
#include <vector>

#include "engine/graph/node_type.h"

namespace tactus {

/// A table of node types whose nodes can be asked afterwards what they were made from. It outlives the plans
/// that are compiled with it.
class RecordedNodes {
 public:
  explicit RecordedNodes(const NodeTable& table);
  RecordedNodes(const RecordedNodes&) = delete;

  const NodeTable& table() const { return table_; }
  /// nullptr for a node that no type of the table made.
  const NodeSetup* setup_of(const Node& node) const;

 private:
  MakeNode recorded(const MakeNode& make);

  NodeTable table_;
  std::vector<std::unique_ptr<NodeType>> types_;
  std::map<const Node*, NodeSetup> setups_;
};

}  // namespace tactus
