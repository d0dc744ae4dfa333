#pragma once

#include <span>
#include <vector>

namespace tactus {

/// [control] Solves  sum over k of r(|n - k|) h(k) = c(n)  for symmetric positive definite r, as long as c:
/// conjugate gradients with a circulant preconditioner, products by Fourier transforms. `r` has at least as
/// many terms. Source: R. Chan, M. Ng, "Conjugate gradient methods for Toeplitz systems", SIAM Review 38,
/// 1996.
std::vector<double> solve_toeplitz(std::span<const double> r, std::span<const double> c);

}  // namespace tactus
