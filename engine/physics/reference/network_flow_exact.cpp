#include <Eigen/Core>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "engine/physics/reference/network_flow.h"

// Networks of linear links:  z' = A z  for the numbers of the state, followed by what is held over a frame
// (forces, voltages, waves, and a 1 for springs' lengths), whose rates are 0. So z at the end of a frame is
// exp(A T) z.
namespace tactus {
namespace {

// Its exponential then takes a second; larger ones are integrated faster than multiplied.
constexpr std::size_t kNetworkFlowExactMostNumbers = 256;

Eigen::Index row_of(std::size_t i) { return static_cast<Eigen::Index>(i); }

}  // namespace

struct NetworkFlow::Transition {
  Eigen::MatrixXd matrix;  ///< from z to the numbers of the state
};

/// The columns of A are the rates of unit vectors. Velocities are counted in units that make the fastest
/// frequency 1, or the exponential would lose digits to large entries.
void NetworkFlow::make_transition() {
  const auto numbers = 2 * points() + elements_.coils.size();
  const auto all = numbers + held();
  const bool linear = laws_.empty() && elements_.frictions.empty() && elements_.bonds.empty();
  if (!linear || all > kNetworkFlowExactMostNumbers) return;
  double fastest = 1.0;
  for (const auto& s : elements_.springs)
    for (const int end : {s.lower, s.upper})
      fastest = std::fmax(fastest, std::sqrt(s.stiffness * inverse_mass_[static_cast<std::size_t>(end)]));
  Eigen::VectorXd unit = Eigen::VectorXd::Ones(row_of(all));
  unit.segment(row_of(points()), row_of(points())).setConstant(fastest);

  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(row_of(all), row_of(all));
  State at_rest;
  at_rest.inputs.assign(held(), 0.0);
  std::vector<double> zero(numbers), constant(numbers), column(numbers);
  rates(at_rest, zero.data(), constant.data());
  for (std::size_t j = 0; j + 1 < all; ++j) {
    double& one = j < numbers ? zero[j] : at_rest.inputs[j - numbers];
    one = 1.0;
    rates(at_rest, zero.data(), column.data());
    one = 0.0;
    for (std::size_t i = 0; i < numbers; ++i) a(row_of(i), row_of(j)) = column[i] - constant[i];
  }
  for (std::size_t i = 0; i < numbers; ++i) a(row_of(i), row_of(all - 1)) = constant[i];
  const Eigen::MatrixXd scaled = frame_s_ * (unit.cwiseInverse().asDiagonal() * a * unit.asDiagonal()).eval();
  const Eigen::MatrixXd exponential =
      unit.asDiagonal() * Eigen::MatrixXd(scaled.exp()) * unit.cwiseInverse().asDiagonal();
  transition_ = std::make_shared<Transition>(Transition{exponential.topRows(row_of(numbers))});
}

void NetworkFlow::multiply(State& state) const {
  const auto numbers = row_of(state.numbers.size()), inputs = row_of(state.inputs.size());
  Eigen::Map<Eigen::VectorXd> next(state.next.data(), numbers);
  next.noalias() = transition_->matrix.leftCols(numbers) *
                   Eigen::Map<const Eigen::VectorXd>(state.numbers.data(), numbers);
  next.noalias() +=
      transition_->matrix.rightCols(inputs) * Eigen::Map<const Eigen::VectorXd>(state.inputs.data(), inputs);
  state.numbers.swap(state.next);
}

}  // namespace tactus
