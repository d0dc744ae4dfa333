#pragma once

// Thread: [control], except where a function says otherwise
#include <memory>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/spec.h"
#include "engine/nodes/networks/network_elements.h"

namespace tactus {

/// The declaration of the one node that `[networks.x]` becomes. Its inputs are the numbers and
/// signals of the elements ("coil.voltage"), its outputs what they can be asked for: "stick.position",
/// "stick" for the first quantity of an element, and "energy" of the whole. Outputs at frame n are the state
/// at n, inputs act from n to n + 1. What elements there are: `network_elements()`. Errors: those of
/// `read_network_layout`.
Checked<std::shared_ptr<const NodeType>> network_type(const NetworkSpec& spec);

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

/// One output of a network.
struct NetworkReading {
  ReadElement read;
  ElementParts parts;

  /// [realtime]
  double value(const Network& network, const NetworkState& state) const noexcept {
    return read.sum(network, state, parts);
  }
};

/// A running network: what its node is beside a `Node`, for studies.
struct NetworkView {
  /// [any] The value of `output` of the node for a state of a network whose elements are in the order of the
  /// recipe's.
  double shown(const Network& of, const NetworkState& at, int output) const {
    return readings[index(output)].value(of, at);
  }

  NetworkRecipe recipe;
  Network network;
  std::vector<NetworkReading> readings;
  NetworkState state = network.initial_state();
};

}  // namespace tactus
