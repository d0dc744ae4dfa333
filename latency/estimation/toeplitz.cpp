#include "latency/estimation/toeplitz.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "latency/estimation/fourier.h"

namespace tactus {
namespace {

constexpr int kToeplitzRounds = 400;
constexpr double kToeplitzSettled = 1e-9;  // of the right side

using Vector = std::vector<double>;

double dot(const Vector& a, const Vector& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Multiplies by the Toeplitz matrix of r, or divides by what is nearly the same: the circle of r under a
/// triangle, whose spectrum is never negative.
class Circle {
 public:
  Circle(std::size_t at_least, std::span<const double> r, std::size_t length, bool under_triangle)
      : fourier_(at_least) {
    const auto size = fourier_.size();
    Vector circle(size, 0.0);
    circle[0] = r[0];
    for (std::size_t k = 1; k < length; ++k) {
      const double weight = under_triangle ? 1.0 - static_cast<double>(k) / static_cast<double>(length) : 1.0;
      circle[k] = circle[size - k] = weight * r[k];
    }
    spectrum_ = fourier_.forward(circle);
  }
  Vector apply(const Vector& x, bool inverse) {
    auto spectrum = fourier_.forward(x);
    for (std::size_t b = 0; b < spectrum.size(); ++b)
      spectrum[b] *= inverse ? 1.0 / std::max(spectrum_[b].real(), 1e-300) : spectrum_[b].real();
    auto y = fourier_.inverse(spectrum);
    y.resize(x.size());
    return y;
  }

 private:
  Fourier fourier_;
  Spectrum spectrum_;
};

}  // namespace

std::vector<double> solve_toeplitz(std::span<const double> r, std::span<const double> c) {
  Circle matrix{2 * c.size(), r, c.size(), false}, nearly{2 * c.size(), r, c.size(), true};
  Vector h(c.size(), 0.0), rest(c.begin(), c.end());
  auto z = nearly.apply(rest, true);
  auto direction = z;
  double strength = dot(rest, z);
  const double settled = kToeplitzSettled * std::sqrt(dot(rest, rest));
  for (int round = 0; round < kToeplitzRounds && std::sqrt(dot(rest, rest)) > settled; ++round) {
    const auto product = matrix.apply(direction, false);
    const double step = strength / dot(direction, product);
    for (std::size_t n = 0; n < h.size(); ++n) {
      h[n] += step * direction[n];
      rest[n] -= step * product[n];
    }
    z = nearly.apply(rest, true);
    const double next = dot(rest, z);
    for (std::size_t n = 0; n < h.size(); ++n) direction[n] = z[n] + next / strength * direction[n];
    strength = next;
  }
  return h;
}

}  // namespace tactus
