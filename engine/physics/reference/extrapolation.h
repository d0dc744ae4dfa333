#pragma once

// Thread: [control]
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace tactus {

/// One step of y' = f(t, y) by the midpoint rule in 2, 4, 6, ... 16 parts, extrapolated to parts of no
/// length:
///     z_1 = y + h f(0, y),  z_m+1 = z_m-1 + 2h f(m h, z_m),  T_j1 = z_2j,  h = H / 2j
///     T_jk = T_j,k-1 + (T_j,k-1 - T_j-1,k-1) / ((j / (j-k+1))^2 - 1)
/// The result T_jj is of order 2j; |T_jj - T_j,j-1| estimates its error. Nothing of it is shared with the
/// solvers that networks are stepped with. Gragg, SIAM J. Numer. Anal. 2, 1965; Hairer, Norsett & Wanner,
/// Solving Ordinary Differential Equations I, II.9.
class Extrapolation {
 public:
  static constexpr std::size_t kColumns = 8;

  /// What came of a step that was tried.
  struct Outcome {
    bool good = false;     ///< the error is tolerated
    double error = 0;      ///< in units of what is tolerated
    double advised_s = 0;  ///< length of the next step, or of the next try
  };

  /// [control] For so many unknowns.
  explicit Extrapolation(std::size_t unknowns = 0)
      : size_(unknowns), start_(unknowns), before_(unknowns), now_(unknowns), slope_(unknowns) {
    for (auto& row : row_) row.resize(unknowns);
  }

  /// [any] `rates(t, y, slope)` with t from the start of the step; `error(y, difference)` in units of what is
  /// tolerated. The result is in `result()`.
  template <class Rates, class Error>
  Outcome step(const Rates& rates, const double* y, double seconds, const Error& error) {
    double last = 0;
    rates(0.0, y, start_.data());
    for (std::size_t j = 0; j < kColumns; ++j) {
      midpoint(rates, y, seconds, 2 * (j + 1));
      extrapolate(j);
      if (j < 2) continue;
      last = error(row_[j].data(), slope_.data());
      if (last <= 1.0) return {true, last, seconds * advice(last, j)};
    }
    return {false, last, seconds * (last == last ? std::min(0.7, advice(last, kColumns - 1)) : 0.1)};
  }

  /// [any] After a step that was good.
  const std::vector<double>& result() const { return row_[columns_ - 1]; }

 private:
  /// The error grows with the (2j - 1)-th power of the step.
  static double advice(double error, std::size_t j) {
    return std::clamp(0.8 * std::pow(std::max(error, 1e-30), -1.0 / static_cast<double>(2 * j + 1)), 0.1,
                      4.0);
  }

  template <class Rates>
  void midpoint(const Rates& rates, const double* y, double seconds, std::size_t parts) {
    const double h = seconds / static_cast<double>(parts);
    for (std::size_t i = 0; i < size_; ++i) {
      before_[i] = y[i];
      now_[i] = y[i] + h * start_[i];
    }
    for (std::size_t m = 1; m < parts; ++m) {
      rates(h * static_cast<double>(m), now_.data(), slope_.data());
      for (std::size_t i = 0; i < size_; ++i) before_[i] += 2.0 * h * slope_[i];
      before_.swap(now_);
    }
  }

  /// Turns the row T_j-1,1 ... T_j-1,j-1 into the next one; the last difference is left in `slope_`.
  void extrapolate(std::size_t j) {
    row_[j].swap(now_);
    for (std::size_t i = 0; i < size_; ++i) {
      double carry = row_[j][i];
      for (std::size_t k = 0; k < j; ++k) {
        const double ratio = static_cast<double>(j + 1) / static_cast<double>(j - k);
        const double old = row_[k][i];
        row_[k][i] = carry;
        slope_[i] = (carry - old) / (ratio * ratio - 1.0);
        carry += slope_[i];
      }
      row_[j][i] = carry;
    }
    columns_ = j + 1;
  }

  std::size_t size_;
  std::vector<double> start_, before_, now_, slope_;
  std::array<std::vector<double>, kColumns> row_;
  std::size_t columns_ = 1;
};

}  // namespace tactus
