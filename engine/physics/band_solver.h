#pragma once

#include <span>
#include <vector>

namespace tactus {

/// Solves A x = b for one symmetric positive definite A, again and again: Cholesky within the band of A
/// (Golub & Van Loan, Matrix Computations, 4.3), made once. A diagonal A costs one multiplication a row; a
/// chain three.
class BandSolver {
 public:
  BandSolver() = default;
  /// [control] `matrix` row by row, size x size.
  BandSolver(std::span<const double> matrix, int size);
  /// [control] The same for a diagonal matrix.
  explicit BandSolver(std::span<const double> diagonal);

  /// [any] False if the matrix was not positive definite, or not in the range of doubles.
  bool valid() const { return valid_; }

  /// [realtime] b becomes x.
  void solve(std::span<double> b) const noexcept;

 private:
  void factor(std::span<const double> matrix);
  double& at(int row, int back) { return lower_[static_cast<std::size_t>(row * (band_ + 1) + back)]; }
  double at(int row, int back) const { return lower_[static_cast<std::size_t>(row * (band_ + 1) + back)]; }

  bool valid_ = true;
  int size_ = 0, band_ = 0;
  // Row i holds L(i, i - back) for back = 0 ... band; back = 0 holds 1 / L(i, i), or 1 / A(i, i) if band = 0.
  std::vector<double> lower_;
};

}  // namespace tactus
