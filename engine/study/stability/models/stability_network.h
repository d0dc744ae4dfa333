#pragma once

// Thread: [control].

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/units.h"
#include "engine/nodes/networks/network.h"
#include "engine/physics/linearised.h"

namespace tactus {

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
  Eigen::MatrixXcd response(std::complex<double> z) const { return response_->at(z); }
  /// False: it has more numbers than `kMostLinearised`, and only its radius is known.
  bool whole() const { return response_.has_value(); }
  /// Input of the node of each signal.
  const std::vector<int>& signal_ports() const { return ports_; }
  /// Rows and columns of the driven point, -1 if nothing is driven.
  int driven_row() const { return driven_row_; }
  int test_force() const { return test_force_; }

  const std::vector<StepMode>& modes() const { return modes_; }
  double radius() const { return radius_; }
  bool grows() const { return radius() > 1.0 + kRoundOfRadius; }
  /// The least stable rate (see `least_rate`); searched at each call.
  std::optional<Hertz> needed_rate() const;
  /// The mode that would grow first: the mass that moves most and the link that it strains most.
  std::string weakest() const;
  const NetworkRecipe& recipe() const { return recipe_; }

 private:
  LinearNetwork() = default;
  void add_fingertip(const Fingertip& hand);
  void add_test_force();
  Eigen::MatrixXd readings(const Network& network, const NetworkView& view, std::size_t outputs,
                           const Touching& touching) const;
  std::string carrier(const StepMode& mode) const;

  NetworkRecipe recipe_;  // with fingertip, test force and tangents
  std::vector<int> ports_;
  std::vector<int> masses_;  // points that are masses, in the order of the state
  int driven_ = -1, driven_row_ = -1, test_force_ = -1;
  std::optional<StepResponse> response_;
  std::vector<StepMode> modes_;
  double radius_ = 0.0;
};

}  // namespace tactus
