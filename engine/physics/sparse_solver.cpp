#include "engine/physics/sparse_solver.h"

#include <Eigen/SparseCholesky>
#include <cmath>

namespace tactus {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

bool is_diagonal(const Matrix& matrix) {
  for (int column = 0; column < matrix.outerSize(); ++column)
    for (Matrix::InnerIterator entry(matrix, column); entry; ++entry)
      if (entry.row() != entry.col() && entry.value() != 0.0) return false;
  return true;
}

}  // namespace

SparseSolver::SparseSolver(const Matrix& matrix) : inverse_(static_cast<std::size_t>(matrix.rows())) {
  const auto take = [this](const auto& diagonal) {
    for (std::size_t i = 0; i < inverse_.size(); ++i) {
      const double d = diagonal[static_cast<Eigen::Index>(i)];
      valid_ = valid_ && d > 0.0 && std::isfinite(d);
      inverse_[i] = 1.0 / d;
    }
  };
  if (is_diagonal(matrix)) {
    take(Eigen::VectorXd(matrix.diagonal()));
    return;
  }
  const Eigen::SimplicialLDLT<Matrix> factor(matrix);
  valid_ = factor.info() == Eigen::Success;
  if (!valid_) return;
  take(factor.vectorD());
  const Matrix lower = factor.matrixL();
  const auto& order = factor.permutationP().indices();  // row i of A stands at order[i]
  place_.resize(inverse_.size());
  for (std::size_t i = 0; i < place_.size(); ++i)
    place_[static_cast<std::size_t>(order[static_cast<Eigen::Index>(i)])] = static_cast<int>(i);
  starts_.push_back(0);
  for (int column = 0; column < lower.outerSize(); ++column) {
    for (Matrix::InnerIterator entry(lower, column); entry; ++entry) {
      if (entry.row() <= column) continue;
      rows_.push_back(static_cast<int>(entry.row()));
      values_.push_back(entry.value());
    }
    starts_.push_back(static_cast<int>(rows_.size()));
  }
}

void SparseSolver::solve(std::span<double> b, std::span<double> work) const noexcept {
  const std::size_t n = inverse_.size();
  if (diagonal()) {
    for (std::size_t i = 0; i < n; ++i) b[i] *= inverse_[i];
    return;
  }
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  for (std::size_t i = 0; i < n; ++i) work[i] = b[at(place_[i])];
  for (std::size_t j = 0; j < n; ++j) {
    const double x = work[j];
    for (std::size_t e = at(starts_[j]); e < at(starts_[j + 1]); ++e) work[at(rows_[e])] -= values_[e] * x;
  }
  for (std::size_t j = n; j-- > 0;) {
    double x = work[j] * inverse_[j];
    for (std::size_t e = at(starts_[j]); e < at(starts_[j + 1]); ++e) x -= values_[e] * work[at(rows_[e])];
    work[j] = x;
  }
  for (std::size_t i = 0; i < n; ++i) b[at(place_[i])] = work[i];
}

}  // namespace tactus
