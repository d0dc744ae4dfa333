#pragma once
// Thread: [control]

#include <complex>
#include <cstddef>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

namespace tactus {

using Spectrum = std::vector<std::complex<double>>;

/// [any] The angular frequency [rad/frame] of a bin of a transform of that size.
inline double angular_frequency(std::size_t bin, std::size_t size) {
  return 2 * std::numbers::pi * static_cast<double>(bin) / static_cast<double>(size);
}

/// [control] |X|² of each bin as its mean over a sixth of an octave around it.
std::vector<double> smoothed_power(const Spectrum& spectrum);

/// The discrete Fourier transform of real signals of one length:  X[b] = sum of x[n] exp(-2πi b n / size),
/// bins 0 to size / 2. Shorter signals count as followed by zeros.
class Fourier {
 public:
  /// [control] Of the next length that is quick to transform.
  explicit Fourier(std::size_t at_least);
  ~Fourier();

  std::size_t size() const { return size_; }
  std::size_t bins() const { return size_ / 2 + 1; }
  /// [control]
  Spectrum forward(std::span<const double> signal);
  /// [control] forward(inverse(X)) = X.
  std::vector<double> inverse(const Spectrum& spectrum);

 private:
  std::size_t size_;
  struct Transform;
  std::unique_ptr<Transform> transform_;
  std::vector<double> padded_;
};

/// [control] Solves  sum over k of r(|n - k|) h(k) = c(n)  for symmetric positive definite r, as long as c:
/// conjugate gradients with a circulant preconditioner, products by Fourier transforms. `r` has at least as
/// many terms. Source: R. Chan, M. Ng, "Conjugate gradient methods for Toeplitz systems", SIAM Review 38,
/// 1996.
std::vector<double> solve_toeplitz(std::span<const double> r, std::span<const double> c);

}  // namespace tactus
