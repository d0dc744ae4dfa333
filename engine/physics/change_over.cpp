#include "engine/physics/change_over.h"

#include <cmath>
#include <limits>

namespace tactus {

Eigen::MatrixXd change_over(const Eigen::MatrixXd& rates) {
  constexpr double kLargest = 1.0 / 32.0;
  constexpr int kTerms = 8;  // what is left out is 1e-17 of the first
  const double norm = rates.size() > 0 ? rates.cwiseAbs().colwise().sum().maxCoeff() : 0.0;
  if (!std::isfinite(norm))
    return Eigen::MatrixXd::Constant(rates.rows(), rates.cols(), std::numeric_limits<double>::quiet_NaN());
  const int doublings = norm > kLargest ? static_cast<int>(std::ceil(std::log2(norm / kLargest))) : 0;
  const Eigen::MatrixXd part = std::ldexp(1.0, -doublings) * rates;
  Eigen::MatrixXd change = part / kTerms, product;
  for (int term = kTerms - 1; term > 0; --term) {
    product.noalias() = part * change;
    change = (part + product) / term;
  }
  for (int i = 0; i < doublings; ++i) {
    product.noalias() = change * change;
    change = 2.0 * change + product;
  }
  return change;
}

}  // namespace tactus
