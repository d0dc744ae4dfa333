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

/// [control] A bond of several axes for small displacements from the places of all points: a spring of the
/// law's stiffness along the line, and springs of force / length across it.
std::vector<Spring> line_springs(const Bond& bond, const std::vector<double>& places);

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

/// H(z) = C (z - A)^-1 B at any z. What a step keeps of the last one only (motions before, inputs that were
/// held) makes poles at 0, J in a row at most; the others, p_k with the eigenvectors V, span what A^J
/// reaches:
///   H = sum_k (C V)_ok R_ki / (z - p_k) + sum_j=1..J c_j z^-j,   R = P^-J V^+ A^J B,
///   c_j = C A^(j-1) B - C V P^(j-1) R,
/// n operations an entry. Where V is too near a singular matrix (a free mass, motions that are nearly alike)
/// or a pole too near 0, A is brought to Hessenberg form: n^2 operations for each input.
class StepResponse {
 public:
  /// `modes`: of `step.a`.
  StepResponse(const LinearStep& step, const Eigen::MatrixXd& c, const std::vector<StepMode>& modes);
  /// All of H.
  Eigen::MatrixXcd at(std::complex<double> z) const;
  /// Whether an entry can be had by itself.
  bool by_modes() const { return poles_.size() > 0; }
  /// [by_modes] From `input` to `output`.
  std::complex<double> at(std::complex<double> z, int output, int input) const;

 private:
  void find_modes(const LinearStep& step, const Eigen::MatrixXd& c, const std::vector<StepMode>& modes);

  void check_modes();

  Eigen::ArrayXcd poles_;                 ///< other than 0; none: not by modes
  Eigen::MatrixXcd into_, out_;           ///< R; transposed C V: what belongs to an entry lies together
  std::vector<Eigen::MatrixXd> at_once_;  ///< c_j
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
