#pragma once
// Thread: [realtime]

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/core/index.h"

namespace tactus {

/// Least squares of  r_k = a + b k + β x_k + ε_k  over k = 0 … n-1, from running sums, for kCount pairs of
/// signals side by side. The errors of β count as those of n' = n (1 - ρ) / (1 + ρ) independent values, ρ:
/// the product of the correlations of x and of ε between neighbours.
template <int kCount>
class FeedbackRegressions {
 public:
  using Values = std::array<double, kCount>;
  struct Estimate {
    Values response;  ///< β
    Values variance;  ///< of x, without its trend. Where it is not positive, β means nothing.
  };

  /// One more value of each of the first `count` pairs whose `weight` is 1; 0: it has none.
  void add(const Values& x, const Values& r, const Values& weight, int count) noexcept {
    for (std::size_t i = 0; i < index(count); ++i) {
      const double neighbours = n_[i] > 0.0 ? weight[i] : 0.0;
      xx1_[i] += neighbours * (x[i] * last_x_[i]);
      xr1_[i] += neighbours * (x[i] * last_r_[i] + r[i] * last_x_[i]);
      rr1_[i] += neighbours * (r[i] * last_r_[i]);
    }
    for (std::size_t i = 0; i < index(count); ++i) {
      const double once = weight[i];
      xt_[i] += once * (x[i] * n_[i]);
      rt_[i] += once * (r[i] * n_[i]);
      n_[i] += once;
      x_[i] += once * x[i];
      r_[i] += once * r[i];
      xx_[i] += once * (x[i] * x[i]);
      xr_[i] += once * (x[i] * r[i]);
      rr_[i] += once * (r[i] * r[i]);
      last_x_[i] = once > 0.0 ? x[i] : last_x_[i];
      last_r_[i] = once > 0.0 ? r[i] : last_r_[i];
    }
  }
  double mean_x(std::size_t i) const noexcept { return x_[i] / n_[i]; }
  double mean_r(std::size_t i) const noexcept { return r_[i] / n_[i]; }
  /// Of the first `count` pairs; from three values on.
  void estimate(int count, Estimate& result) const noexcept {
    for (std::size_t i = 0; i < index(count); ++i) {
      const Sums sums = without_trend(i);
      result.response[i] = sums.xr / sums.xx;
      result.variance[i] = sums.xx / n_[i];
    }
  }
  /// β of pair i by its standard error.
  double t(std::size_t i) const noexcept {
    const Sums sums = without_trend(i);
    const double response = sums.xr / sums.xx;
    const double error = std::max(0.0, sums.rr - response * sums.xr) / n_[i] + kLeastError;
    return response / std::sqrt(error * n_[i] / (sums.xx * independent(i, response, error, sums.xx)));
  }

 private:
  static constexpr double kLeastError = 1e-4;  ///< of ε²: levels are never better known than to 0.01 Np
  static constexpr double kMost = 0.98;

  /// Of products, without means and trends.
  struct Sums {
    double xx, rr, xr;
  };
  Sums without_trend(std::size_t i) const noexcept {
    const double n = n_[i], x = x_[i], r = r_[i];
    const double half = (n - 1.0) / 2.0, tt = n * (n * n - 1.0) / 12.0;
    const double xt = xt_[i] - x * half, rt = rt_[i] - r * half;
    return {xx_[i] - x * x / n - xt * xt / tt, rr_[i] - r * r / n - rt * rt / tt,
            xr_[i] - x * r / n - xt * rt / tt};
  }

  /// n'
  double independent(std::size_t i, double response, double error, double xx) const noexcept {
    const double mx = mean_x(i), mr = mean_r(i), pairs = n_[i] - 1.0;
    const double cxx = xx1_[i] / pairs - mx * mx, crr = rr1_[i] / pairs - mr * mr;
    const double cxr = xr1_[i] / pairs - 2.0 * mx * mr;
    const double ce = crr - response * cxr + response * response * cxx;
    const double rho = std::clamp(ce / error, 0.0, kMost) * std::clamp(cxx * n_[i] / xx, 0.0, kMost);
    return n_[i] * (1.0 - rho) / (1.0 + rho);
  }

  Values n_{}, x_{}, r_{}, xx_{}, xr_{}, rr_{};
  Values xt_{}, rt_{};            // with k
  Values xx1_{}, xr1_{}, rr1_{};  // with the value before
  Values last_x_{}, last_r_{};
};

}  // namespace tactus
