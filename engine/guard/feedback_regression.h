#pragma once
// Thread: [realtime]

#include <algorithm>
#include <cmath>

namespace tactus {

/// Least squares of  r_k = a + b k + β x_k + ε_k  over k = 0 … n-1, from running sums. The errors of β count
/// as those of n' = n (1 - ρ) / (1 + ρ) independent values, ρ: the product of the correlations of x and of ε
/// between neighbours.
class FeedbackRegression {
 public:
  struct Fit {
    double response = 0.0;  ///< β
    double t = 0.0;         ///< β / its standard error
    double variance = 0.0;  ///< of x, without its trend
  };

  void add(double x, double r) noexcept {
    if (n_ > 0.0) {
      xx1_ += x * last_x_;
      xr1_ += x * last_r_ + r * last_x_;
      rr1_ += r * last_r_;
    }
    xt_ += x * n_;
    rt_ += r * n_;
    n_ += 1.0;
    x_ += x;
    r_ += r;
    xx_ += x * x;
    xr_ += x * r;
    rr_ += r * r;
    last_x_ = x;
    last_r_ = r;
  }
  double mean_x() const noexcept { return x_ / n_; }
  double mean_r() const noexcept { return r_ / n_; }
  /// From three values on.
  Fit fit() const noexcept {
    const double half = (n_ - 1.0) / 2.0, tt = n_ * (n_ * n_ - 1.0) / 12.0;
    const double xt = xt_ - x_ * half, rt = rt_ - r_ * half;
    const double xx = xx_ - x_ * x_ / n_ - xt * xt / tt, rr = rr_ - r_ * r_ / n_ - rt * rt / tt;
    const double xr = xr_ - x_ * r_ / n_ - xt * rt / tt;
    if (!(xx > 0.0)) return {};
    const double response = xr / xx;
    const double error = std::max(0.0, rr - response * xr) / n_ + kLeastError;
    return {response, response / std::sqrt(error * n_ / (xx * independent(response, error, xx))), xx / n_};
  }

 private:
  static constexpr double kLeastError = 1e-4;  ///< of ε²: levels are never better known than to 0.01 Np
  static constexpr double kMost = 0.98;

  /// n'
  double independent(double response, double error, double xx) const noexcept {
    const double mx = mean_x(), mr = mean_r(), pairs = n_ - 1.0;
    const double cxx = xx1_ / pairs - mx * mx, crr = rr1_ / pairs - mr * mr;
    const double cxr = xr1_ / pairs - 2.0 * mx * mr;
    const double ce = crr - response * cxr + response * response * cxx;
    const double rho = std::clamp(ce / error, 0.0, kMost) * std::clamp(cxx * n_ / xx, 0.0, kMost);
    return n_ * (1.0 - rho) / (1.0 + rho);
  }

  double n_ = 0, x_ = 0, r_ = 0, xx_ = 0, xr_ = 0, rr_ = 0;
  double xt_ = 0, rt_ = 0;              ///< with k
  double xx1_ = 0, xr1_ = 0, rr1_ = 0;  ///< with the value before
  double last_x_ = 0, last_r_ = 0;
};

}  // namespace tactus
