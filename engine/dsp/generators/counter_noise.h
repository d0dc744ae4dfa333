#pragma once

#include <cmath>
#include <cstdint>

namespace tactus {

/// Noise as a function of the frame number instead of a running generator: any frame can be asked for in any
/// order, so that blocks, restarts and lanes cannot change it.
///   u(n) = mix(key + (n + 1) * 0x9e3779b97f4a7c15),  key = mix(mix(seed) + lane)
/// `mix` is the finaliser of SplitMix64 (Steele, Lea, Flood, "Fast splittable pseudorandom number
/// generators", OOPSLA 2014, with the constants of Stafford's variant 13).
class CounterNoise {
 public:
  CounterNoise(std::uint64_t seed, std::uint64_t lane) : key_(mix(mix(seed) + lane)) {}

  /// Even in [-1, 1): mean 0, variance 1/3.
  double uniform(std::int64_t frame) const {
    return static_cast<double>(bits(static_cast<std::uint64_t>(frame)) >> 11) * 0x1p-52 - 1.0;
  }

  /// Normal, mean 0, variance 1, |value| < 8.6. Box and Muller (1958), the cosine half.
  double gaussian(std::int64_t frame) const {
    const auto counter = 2 * static_cast<std::uint64_t>(frame);
    const double radius = static_cast<double>((bits(counter) >> 11) + 1) * 0x1p-53;  // never 0
    const double turn = static_cast<double>(bits(counter + 1) >> 11) * 0x1p-53;
    return std::sqrt(-2.0 * std::log(radius)) * std::cos(6.283185307179586 * turn);
  }

 private:
  static constexpr std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint64_t bits(std::uint64_t counter) const { return mix(key_ + (counter + 1) * 0x9e3779b97f4a7c15u); }

  std::uint64_t key_;
};

}  // namespace tactus
