#include "engine/physics/band_solver.h"

#include <algorithm>
#include <cmath>

namespace tactus {

BandSolver::BandSolver(std::span<const double> diagonal)
    : size_(static_cast<int>(diagonal.size())), lower_(diagonal.begin(), diagonal.end()) {
  for (auto& d : lower_) {
    valid_ = valid_ && d > 0.0 && std::isfinite(d);
    d = 1.0 / d;
  }
}

BandSolver::BandSolver(std::span<const double> matrix, int size) : size_(size) {
  for (int i = 0; i < size_; ++i)
    for (int j = 0; j < i; ++j)
      if (matrix[static_cast<std::size_t>(i * size_ + j)] != 0.0) band_ = std::max(band_, i - j);
  lower_.assign(static_cast<std::size_t>(size_ * (band_ + 1)), 0.0);
  factor(matrix);
}

void BandSolver::factor(std::span<const double> matrix) {
  for (int i = 0; i < size_; ++i) {
    for (int j = std::max(0, i - band_); j <= i; ++j) {
      double sum = matrix[static_cast<std::size_t>(i * size_ + j)];
      for (int k = std::max(0, i - band_); k < j; ++k)
        if (j - k <= band_) sum -= at(i, i - k) * at(j, j - k);
      if (i == j) valid_ = valid_ && sum > 0.0 && std::isfinite(sum);
      at(i, i - j) = i != j ? sum * at(j, 0) : band_ > 0 ? 1.0 / std::sqrt(sum) : 1.0 / sum;
    }
  }
}

void BandSolver::solve(std::span<double> b) const noexcept {
  const auto n = static_cast<std::size_t>(size_);
  if (band_ == 0) {
    for (std::size_t i = 0; i < n; ++i) b[i] *= lower_[i];
    return;
  }
  for (int i = 0; i < size_; ++i) {
    double sum = b[static_cast<std::size_t>(i)];
    for (int back = std::min(i, band_); back > 0; --back)
      sum -= at(i, back) * b[static_cast<std::size_t>(i - back)];
    b[static_cast<std::size_t>(i)] = sum * at(i, 0);
  }
  for (int i = size_ - 1; i >= 0; --i) {
    const double x = b[static_cast<std::size_t>(i)] *= at(i, 0);
    for (int back = std::min(i, band_); back > 0; --back)
      b[static_cast<std::size_t>(i - back)] -= at(i, back) * x;
  }
}

}  // namespace tactus
