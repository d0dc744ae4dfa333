#pragma once

// Thread: [control].

#include <complex>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/graph/node.h"
#include "engine/study/stability/models/nonlinearities.h"
#include "engine/study/stability/models/stability_network.h"

namespace tactus {

/// The small-signal effect of one signal of a graph on another.
struct LinearEdge {
  enum class Kind {
    Gain,
    Delay,    ///< z^-frames
    Node,     ///< Node::response
    Network,  ///< of LinearNetwork
    Event,    ///< event-driven or unknown: it has no gain, and closes no linear loop
  };
  Kind kind = Kind::Gain;
  int from = 0, to = 0;
  std::string path;  ///< of the node or expression
  double gain = 1;
  int frames = 0;  ///< Delay; of others the longest that is promised
  std::shared_ptr<const Node> node = {};
  int input = 0, output = 0;    ///< of the node; column and row of a network's model
  std::vector<double> at = {};  ///< the node's inputs
  int network = -1;
  int divisor = 1;  ///< engine frames between two of those that it runs in
};

/// A place where a force answers a position: what can be too stiff.
struct StiffPlace {
  int signal = 0;  ///< between the position and the force
  std::string path, type;
  double stiffness = 0;  ///< [N/m]
  bool touched = false;  ///< as it is in contact, not at rest
};

/// An event-driven node, without a small-signal gain: it waits, decides or is moved.
struct EventPlace {
  std::string path, type;
  std::optional<double> hold_s;  ///< no two events are closer
};

/// Which operating point is analysed: contacts open or closed, free or held.
struct Regime {
  std::string name = "at rest";
  bool touched = false;  ///< laws without memory where they are steepest: behind the wall, on the slope
  Displaced moved = {};  ///< touched: where these signals take them; others are taken each by itself
  std::map<std::string, Touching> contacts = {};  ///< [path of the network]
  std::optional<Fingertip> hand = {};
};

/// The small-signal model of one or several plans.
struct LinearGraph {
  std::vector<std::string> signals;  ///< names, for people
  std::vector<LinearEdge> edges;
  std::vector<std::shared_ptr<const LinearNetwork>> networks;
  std::vector<std::string> network_paths;
  std::vector<std::string> skipped;  ///< networks that are too large to analyse
  std::vector<StiffPlace> stiff;
  std::vector<EventPlace> events;
  std::vector<std::string> unstable_equilibria;  ///< nonlinearities whose force pushes away at the operating
                                                 ///< point and restores elsewhere: left out
  std::vector<int> wave_ports;                   ///< waves that leave a network
  std::vector<Nonlinearity> laws;                ///< that answer otherwise elsewhere
  bool nonlinear = false;                        ///< some force answers a position otherwise elsewhere
  bool has_touched = false;                      ///< some law is steeper elsewhere than where it rests

  int add_signal(std::string name);
  void join(int from, int to) { edges.push_back({.from = from, .to = to, .path = {}}); }
  void delay(int from, int to, int frames);
  /// [control] The gains at z of some of the edges.
  void gains(std::complex<double> z, const std::vector<std::size_t>& of,
             std::vector<std::complex<double>>& gains) const;
};

}  // namespace tactus
