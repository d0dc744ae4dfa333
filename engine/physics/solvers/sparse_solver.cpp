#include "engine/physics/solvers/sparse_solver.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/core/index.h"

namespace tactus {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using InOrder = Eigen::SimplicialLDLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>>;
using Reordered = Eigen::SimplicialLDLT<Sparse>;

/// How many rows the farthest number lies from the diagonal. Up to 1, the own order fills in nothing.
int bandwidth(const Sparse& matrix) {
  int most = 0;
  for (int column = 0; column < matrix.outerSize(); ++column)
    for (Sparse::InnerIterator entry(matrix, column); entry; ++entry)
      if (entry.value() != 0.0) most = std::max(most, std::abs(static_cast<int>(entry.row() - entry.col())));
  return most;
}

}  // namespace

void SparseSolver::take_diagonal(const Eigen::VectorXd& diagonal) {
  for (std::size_t i = 0; i < inverse_.size(); ++i) {
    inverse_[i] = 1.0 / diagonal[static_cast<Eigen::Index>(i)];
    valid_ = valid_ && inverse_[i] > 0.0 && std::isfinite(inverse_[i]);
  }
}

template <class Factor>
void SparseSolver::take(const Factor& factor) {
  valid_ = factor.info() == Eigen::Success;
  if (!valid_) return;
  take_diagonal(factor.vectorD());
  const Sparse lower = factor.matrixL();
  starts_.push_back(0);
  for (int column = 0; column < lower.outerSize(); ++column) {
    for (Sparse::InnerIterator entry(lower, column); entry; ++entry) {
      if (entry.row() <= column) continue;
      rows_.push_back(static_cast<int>(entry.row()));
      values_.push_back(entry.value());
    }
    starts_.push_back(static_cast<int>(rows_.size()));
  }
}

SparseSolver::SparseSolver(const Sparse& matrix)
    : inverse_(index(static_cast<int>(matrix.rows()))), place_(inverse_.size()) {
  const int band = bandwidth(matrix);
  if (band == 0) {
    take_diagonal(matrix.diagonal());
    return;
  }
  std::iota(place_.begin(), place_.end(), 0);
  if (band == 1) {
    take(InOrder(matrix));
    chain_ = rows_.size() + 1 == inverse_.size();
    return;
  }
  const Reordered factor(matrix);
  take(factor);
  const auto& order = factor.permutationP().indices();  // row i of A is at order[i]
  for (std::size_t i = 0; i < place_.size(); ++i)
    place_[index(order[static_cast<Eigen::Index>(i)])] = static_cast<int>(i);
}

/// The last result stays in a register.
void SparseSolver::solve_chain(std::span<double> b) const noexcept {
  const std::size_t n = inverse_.size();
  double x = b[0];
  for (std::size_t i = 1; i < n; ++i) b[i] = x = b[i] - values_[i - 1] * x;
  b[n - 1] = x = b[n - 1] * inverse_[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) b[i] = x = b[i] * inverse_[i] - values_[i] * x;
}

void SparseSolver::solve(std::span<double> b, std::span<double> work) const noexcept {
  const std::size_t n = inverse_.size();
  if (diagonal()) {
    for (std::size_t i = 0; i < n; ++i) b[i] *= inverse_[i];
    return;
  }
  if (chain_) return solve_chain(b);
  for (std::size_t i = 0; i < n; ++i) work[i] = b[index(place_[i])];
  for (std::size_t j = 0; j < n; ++j) {
    const double x = work[j];
    for (std::size_t e = index(starts_[j]); e < index(starts_[j + 1]); ++e)
      work[index(rows_[e])] -= values_[e] * x;
  }
  for (std::size_t j = n; j-- > 0;) {
    double x = work[j] * inverse_[j];
    for (std::size_t e = index(starts_[j]); e < index(starts_[j + 1]); ++e)
      x -= values_[e] * work[index(rows_[e])];
    work[j] = x;
  }
  for (std::size_t i = 0; i < n; ++i) b[index(place_[i])] = work[i];
}

}  // namespace tactus
