#pragma once

// Thread: [any].

#include <array>
#include <cstddef>

namespace tactus {

/// product over j != k of (k - j)
template <std::size_t Taps>
constexpr std::array<double, Taps> lagrange_divisors() {
  std::array<double, Taps> divisors{};
  for (std::size_t k = 0; k < Taps; ++k) {
    divisors[k] = 1;
    for (std::size_t j = 0; j < Taps; ++j)
      if (j != k) divisors[k] *= static_cast<double>(k) - static_cast<double>(j);
  }
  return divisors;
}

/// Weights that read between samples: the polynomial through Order + 1 taps at 0, 1 … Order frames, taken at
/// `t` frames from the newest:
///
///   w[k] = product over j != k of (t - j) / (k - j)
///
/// Exact for polynomials up to Order. In the middle interval (t between (Order-1)/2 and (Order+1)/2) the gain
/// is at most 1 at every frequency, which makes it safe in a loop; outside it rises above 1 at high
/// frequencies. Source: Laakso, Valimaki, Karjalainen & Laine, "Splitting the unit delay", IEEE SP Magazine
/// 13, 1996.
template <int Order>
std::array<double, Order + 1> lagrange_weights(double t) noexcept {
  static_assert(Order == 1 || Order == 3 || Order == 5);
  constexpr std::size_t kTaps = Order + 1;
  std::array<double, kTaps> w{};
  double product = 1;
  for (std::size_t k = 0; k < kTaps; ++k) {
    w[k] = product;
    product *= t - static_cast<double>(k);
  }
  constexpr auto divisors = lagrange_divisors<kTaps>();
  product = 1;
  for (std::size_t k = kTaps; k-- > 0;) {
    w[k] *= product / divisors[k];
    product *= t - static_cast<double>(k);
  }
  return w;
}

}  // namespace tactus
