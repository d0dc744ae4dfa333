#pragma once

// Thread: [control].

#include <complex>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/prefixed.h"
#include "engine/core/units.h"
#include "engine/graph/node.h"
#include "engine/nodes/networks/network.h"
#include "engine/physics/linearised.h"
#include "engine/study/stability/models/nonlinearities.h"

namespace tactus {

/// [m^2] Where something turns, what has a mass or a damping is 10 mm from the axis.
inline constexpr double kSquareRadius = 1e-4;

/// A fingertip on the driven point: the damping and mass that it adds. Defaults after Hajian & Howe, J.
/// Biomech. Eng. 119, 1997: 1 ... 5 N s/m, 5 ... 10 g.
struct Fingertip {
  double damping = 2.0;  ///< [N s/m]
  double mass = 0.006;   ///< [kg]
};

/// Small-signal model of a network by itself.
class LinearNetwork {
 public:
  /// [control] nullptr if it cannot be stepped.
  static std::shared_ptr<const LinearNetwork> make(const NetworkView& view, const NodeType& type,
                                                   const Touching& touching,
                                                   const std::optional<Fingertip>& hand);

  /// H(z): rows are the outputs of the node, then the position of the first driven point; columns are the
  /// signals of the recipe, then a test force on that point.
  const StepResponse& response() const { return *response_; }
  /// False: it has more numbers than `kMostLinearised`, and only its radius is known.
  bool whole() const { return response_.has_value(); }
  bool grows() const { return radius > 1.0 + kRoundOfRadius; }
  /// The least stable rate (see `least_rate`); searched at each call.
  std::optional<Hertz> needed_rate() const;
  /// The mode that would grow first: the mass that moves most and the link that it strains most.
  std::string weakest() const;

  NetworkElements written;               ///< its elements as they are in the file
  NetworkRecipe recipe;                  ///< with fingertip, test force and tangents; knows the node's inputs
  int driven_row = -1, test_force = -1;  ///< row and column of the driven point, -1 if nothing is driven
  std::vector<StepMode> modes = {};
  double radius = 0.0;

 private:
  LinearNetwork() = default;
  void add_fingertip(const Fingertip& hand);
  void add_test_force();
  Eigen::MatrixXd readings(const Network& network, const NetworkView& view, std::size_t outputs,
                           const Touching& touching) const;
  std::string carrier(const StepMode& mode) const;

  std::vector<int> masses_;  // points that are masses, in the order of the state
  int driven_ = -1;
  std::optional<StepResponse> response_;
};

/// The small-signal effect of one signal of a graph on another.
struct LinearEdge {
  enum class Kind {
    Gain,
    Delay,    ///< z^-frames
    Node,     ///< Node::response
    Network,  ///< of LinearNetwork
    Hold,     ///< (1 + z^-1 + ... z^-(frames - 1)) / frames: what is sampled once in `frames` and held
    Event,    ///< event-driven or unknown: it has no gain, and closes no linear loop
  };
  Kind kind = Kind::Gain;
  int from = 0, to = 0;
  std::string path;  ///< of the node or expression
  double gain = 1;
  int frames = 0;  ///< Delay, Hold; of others the longest that is promised
  std::shared_ptr<const Node> node = {};
  int input = 0, output = 0;                          ///< of the node; column and row of a network's model
  std::vector<double> at = {};                        ///< the node's inputs
  std::optional<std::complex<double>> constant = {};  ///< the node's response where it is the same at every z
  int network = -1;
  int divisor = 1;       ///< engine frames between two of those that it runs in
  bool limited = false;  ///< of events: a hold time keeps them apart
};

/// A force that depends on a position, as of a spring: it can be too stiff.
struct StiffPlace {
  int signal = 0;  ///< between the position and the force
  std::string path, type;
  double stiffness = 0;  ///< [N/m], or [N m/rad] where it turns
  bool turns = false;
  std::string with_unit(double some_stiffness) const {
    return prefixed(some_stiffness, turns ? "N m/rad" : "N/m");
  }
};

/// An event-driven node, without a small-signal gain.
struct EventPlace {
  std::string path, type;
  std::optional<double> hold_s = {};  ///< least time between two events
  bool on_loop = false;               ///< its events close one
};

/// Which operating point is analysed: contacts open or closed, free or held.
struct Regime {
  std::string name = "at rest";
  bool certain = true;     ///< false: its laws may never be where they are taken together
  bool touched = false;    ///< nonlinearities at their steepest point: behind the wall, on the slope
  bool all_paths = false;  ///< signals that have no effect there, as a product with 0, are joined too
  Displaced moved = {};    ///< touched: the displacements that lead there; others are displaced one by one
  std::map<std::string, Touching> contacts = {};  ///< [path of the network]
  std::optional<Fingertip> hand = {};
};

/// The small-signal model of one or several plans.
struct LinearGraph {
  std::vector<std::string> signals;  ///< names, for reports
  std::vector<int> divisors;         ///< [signal] engine frames between two of its samples
  std::vector<LinearEdge> edges;
  std::vector<std::shared_ptr<const LinearNetwork>> networks;
  std::vector<std::string> network_paths;
  std::vector<std::string> skipped;  ///< networks that are too large to analyse
  std::vector<StiffPlace> stiff;
  std::vector<EventPlace> events;
  std::vector<std::pair<int, std::string>>
      unclocked;                                 ///< inputs of nodes that sample without a regular clock
  std::vector<std::string> unstable_equilibria;  ///< nonlinearities whose force pushes away at the operating
                                                 ///< point and restores elsewhere: left out
  std::vector<int> wave_ports;                   ///< waves that leave a network
  std::vector<Nonlinearity> laws;                ///< whose slope depends on the operating point
  bool nonlinear = false;                        ///< the stiffness of some force depends on the position
  bool has_touched = false;                      ///< some law has another slope elsewhere than at rest
  bool varies = false;       ///< some gain depends on a signal: a product, a parameter that moves, an event
  bool all_combined = true;  ///< false: there are more combinations of laws than are analysed

  int add_signal(std::string name, int divisor = 1) {
    signals.push_back(std::move(name));
    divisors.push_back(divisor);
    return static_cast<int>(signals.size()) - 1;
  }
  void join(int from, int to) { edges.push_back({.from = from, .to = to, .path = {}}); }
  void delay(int from, int to, int frames) {
    edges.push_back({.kind = LinearEdge::Kind::Delay, .from = from, .to = to, .path = {}, .frames = frames});
  }
};

/// Connections of a plan to the outside: signals in the graph, -1 if not read or constant.
struct Terminals {
  std::vector<int> inputs;    ///< in the order of Plan::input_names
  std::vector<int> channels;  ///< in the order of Plan::channels, taps included
};
/// Which input of a node triggers its sampling of the first one; -1: none.
int sampling_trigger(const NodeType& type);

/// How many frames lie between two samples of the nodes that sample at a trigger; 0: it was not the same
/// number twice in a row.
using SamplingClocks = std::map<const Node*, int>;
/// Adds a plan (compiled with `vectorise` off) at the operating point of its signals: it must have run, and
/// last for one frame. `prefix` comes before its names.
Terminals add_plan(LinearGraph& graph, const Plan& plan, const SamplingClocks& clocks, const Regime& regime,
                   const std::string& prefix);

}  // namespace tactus
