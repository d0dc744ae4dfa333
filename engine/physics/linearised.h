#pragma once

// Thread: [control]
#include <Eigen/Core>
#include <complex>
#include <optional>
#include <vector>

#include "engine/core/error.h"
#include "engine/physics/network.h"

namespace tactus {

/// The operating point of a linearisation: which contacts are closed, and with which force [N].
struct Touching {
  std::vector<int> contacts;  ///< in the order of the elements; all others are open
  double push = 10.0;
};

/// [control] The small-signal network: an open contact is absent, a closed one is the spring and the damper
/// that it is at the indentation n where F = K n^a is the push,
///     k = a F / n,   z = F r.
/// The contacts stay in the list, far apart, so that all parts keep their index; the springs that replace
/// the closed ones are appended. A contact with a restitution is taken without its loss. A bond is
/// the spring that it is where its points are: below 0 where its force falls with the distance.
NetworkElements tangent(NetworkElements elements, const Touching& touching);

/// One step of a network from frame to frame as a linear map of its state and of its inputs,
///     x+ = A x + B u,
/// found by stepping it from each unit of the state: true for every solver. Exact
/// but for rounding where no contact can open or close (see `tangent`).
/// The state: positions and motions of all that moves [m], currents [A], inputs of the last frame,
/// low-passes.
struct LinearStep {
  Eigen::MatrixXd a, b;
};
/// [control] The states in which all of x is 0 but one number, which is `size`.
std::vector<NetworkState> unit_states(const Network& network, const NetworkElements& elements, double size);
LinearStep linear_step(const Network& network, const NetworkElements& elements, int signals);

/// [control] How many numbers the state has; above `kMostLinearised` its matrix takes too long.
std::size_t state_size(const NetworkElements& elements, int signals);
inline constexpr std::size_t kMostLinearised = 300;

/// A mode of a linear step: z^n with z = radius e^(j 2 pi frequency / rate).
struct StepMode {
  std::complex<double> pole;
  Eigen::VectorXcd shape;  ///< of the state
};
/// [control] All of them, the ones that grow fastest first.
std::vector<StepMode> modes(const Eigen::MatrixXd& a);

/// Within rounding: a mass that nothing holds has a double pole at 1, which comes out as 1 +- 1e-8.
inline constexpr double kRoundOfRadius = 1e-7;
/// [control] Largest |pole|.
double spectral_radius(const Eigen::MatrixXd& a);

/// [control] The same for any size, by running the network for some thousand frames from random
/// motions: their growth a frame, or 1 if they do not grow. Detects growth of more than a thousandth a frame.
double radius_by_running(const Network& network, const NetworkElements& elements, int signals);

/// C (z - A)^-1 B at any z, after A was brought to Hessenberg form once: n^2 operations for each input.
class StepResponse {
 public:
  StepResponse(const LinearStep& step, const Eigen::MatrixXd& c);
  Eigen::MatrixXcd at(std::complex<double> z) const;

 private:
  /// Row by row in memory: elimination goes along rows.
  using Rows = Eigen::Matrix<std::complex<double>, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Rows minus_h_;
  Eigen::MatrixXcd b_, c_;
};

/// [control] The largest |pole| of the elements, run so. Errors: of Network::make.
Result<double> radius_of(const NetworkElements& elements, int signals, Hertz rate, Solver solver);
/// [control] The least rate (times oversample) at which no mode grows, to a thousandth, between 100 Hz and
/// 100 MHz. nullopt: one grows at none of these; infinite: one grows at all of them.
std::optional<Hertz> least_rate(const NetworkElements& elements, int signals, Solver solver);

}  // namespace tactus
