#pragma once

// Thread: [any], except where a function says otherwise
#include <Eigen/SparseCore>
#include <span>
#include <vector>

namespace tactus {

/// Solves A x = b for one symmetric positive definite A, again and again:  P A P^T = L D L^T, made once, with
/// the rows in an order that keeps L sparse (approximate minimum degree; Amestoy, Davis & Duff, SIAM J.
/// Matrix Anal. Appl. 17, 1996). A diagonal A costs one multiplication a row, a chain four, a grid of n x n
/// about 8 log2(n).
class SparseSolver {
 public:
  SparseSolver() = default;
  /// [control] Both halves of A, or its lower one.
  explicit SparseSolver(const Eigen::SparseMatrix<double>& matrix);

  /// [any] False if the matrix was not positive definite, or not in the range of doubles.
  bool valid() const { return valid_; }
  bool diagonal() const { return rows_.empty(); }
  /// [any] Multiplications of `solve`.
  std::size_t multiplications() const { return inverse_.size() + 2 * rows_.size(); }

  /// [realtime] b becomes x. `work` has as many places as b.
  void solve(std::span<double> b, std::span<double> work) const noexcept;

 private:
  void take_diagonal(const Eigen::VectorXd& diagonal);
  template <class Factor>
  void take(const Factor& factor);
  void solve_chain(std::span<double> b) const noexcept;

  bool valid_ = true;
  std::vector<double> inverse_;     // 1 / D
  std::vector<int> place_;          // row of b that comes i-th
  std::vector<int> starts_, rows_;  // of L's columns, without the diagonal
  std::vector<double> values_;
  bool chain_ = false;  // no permutation; L has but one diagonal beside its own
};

}  // namespace tactus
