#pragma once

// Thread: [control], except where a function says otherwise
#include <memory>
#include <string>
#include <vector>

#include "engine/graph/node.h"
#include "engine/graph/node_type.h"
#include "engine/nodes/networks/network_layout.h"

namespace tactus {

/// One output of a network: what to read of which parts.
struct NetworkReading {
  ReadElement read;
  ElementParts parts;
};

/// What a network node was made from, and how its parts are called in the file.
struct NetworkRecipe {
  NetworkElements elements;
  int signals = 0;
  Hertz rate;
  Solver solver = Solver::Passive;
  int oversample = 1;
  std::vector<int> signal_ports;                       ///< input of the node of each signal
  std::vector<std::string> points, springs, contacts;  ///< names of the elements, in their order
};

/// What studies read from the node of a network.
class NetworkView {
 public:
  virtual ~NetworkView() = default;
  /// [any]
  virtual const NetworkRecipe& recipe() const = 0;
  /// [any] The value of `output` of the node for a state of `network`, whose elements are in the order of
  /// the recipe's.
  virtual double shown(const Network& network, const NetworkState& state, int output) const = 0;
  /// [control & stopped] What is stored in it now [J].
  virtual double energy() const = 0;
  /// [control & stopped] Where a point is now [m].
  virtual double position(int point) const = 0;
};

/// The running node of a network: outputs at frame n are the state at n, inputs act from n to n
/// + 1.
Result<std::unique_ptr<Node>> make_network_node(const NetworkLayout& layout, const NodeSetup& setup);

}  // namespace tactus
