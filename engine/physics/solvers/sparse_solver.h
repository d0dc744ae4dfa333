#pragma once

// Thread: [any], except where a function says otherwise
#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "engine/physics/solvers/triangular_sweep.h"

namespace tactus {

/// Solves A x = b for one symmetric positive definite A, again and again:  P A P^T = L D L^T, made once, with
/// the rows in an order that keeps L sparse (`elimination_order.h`) and with rows of L and of L^T that look
/// alike in the lanes of a register. A diagonal A costs one multiplication a row, a chain four, a grid of n
/// rows at most 31/4 log2(n).
class SparseSolver {
 public:
  SparseSolver() = default;
  /// [control] Both halves of A, or its lower one.
  explicit SparseSolver(const Eigen::SparseMatrix<double>& matrix);

  /// [any] False if the matrix was not positive definite, or not in the range of doubles.
  bool valid() const { return valid_; }
  bool diagonal() const { return entries_ == 0; }
  /// [any] Multiplications of `solve`, without those by 0 in idle lanes.
  std::size_t multiplications() const { return inverse_.size() + 2 * entries_; }
  /// [any] Numbers that `solve` needs to work with: up to twice as many as rows.
  std::size_t workspace() const { return row_.size(); }

  /// [any] What `solve` goes through: 1 / D by row, the other diagonal of L of a chain (else empty), row and
  /// slot of each other, and both sweeps.
  const std::vector<double>& inverse() const { return inverse_; }
  const std::vector<double>& below() const { return below_; }
  const std::vector<int>& rows() const { return row_; }
  const std::vector<int>& slots() const { return slot_; }
  const TriangularSweep& forward() const { return forward_; }
  const TriangularSweep& backward() const { return backward_; }

  /// [realtime] b becomes x. `work` has `workspace()` places.
  void solve(std::span<double> b, std::span<double> work) const noexcept;

 private:
  void take_diagonal(const Eigen::VectorXd& diagonal);
  void factor_chain(const Eigen::SparseMatrix<double>& matrix);
  void factor(const Eigen::SparseMatrix<double>& matrix);
  void solve_chain(std::span<double> b) const noexcept;

  bool valid_ = true;
  std::size_t entries_ = 0;      // of L below its diagonal
  std::vector<double> inverse_;  // 1 / D, by row
  std::vector<double> below_;    // of a chain: L's other diagonal
  std::vector<int> row_, slot_;  // of each slot, of each row
  TriangularSweep forward_, backward_;
};

}  // namespace tactus
