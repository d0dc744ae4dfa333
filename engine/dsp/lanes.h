#pragma once

#include "engine/core/realtime.h"

#if defined(__AVX512F__) || (defined(__AVX2__) && defined(__FMA__))
#include <immintrin.h>
#endif

namespace tactus {

/// Eight doubles that are worked on at once. Written out for the vector units because compilers turn a loop
/// of eight fused multiply-adds into eight scalar ones; every variant rounds alike, so the bits are the same
/// on all machines that have the instruction.
struct Lanes {
  static constexpr int kCount = 8;

#if defined(__AVX512F__)
  __m512d all;

  static Lanes same(double x) noexcept { return {_mm512_set1_pd(x)}; }
  static Lanes load(const double* x) noexcept { return {_mm512_loadu_pd(x)}; }
  void store(double* x) const noexcept { _mm512_storeu_pd(x, all); }
  /// One lane in every lane.
  template <int Lane>
  Lanes spread() const noexcept {
    return {__builtin_shufflevector(all, all, Lane, Lane, Lane, Lane, Lane, Lane, Lane, Lane)};
  }
  friend Lanes operator+(Lanes a, Lanes b) noexcept { return {_mm512_add_pd(a.all, b.all)}; }
  friend Lanes operator*(Lanes a, Lanes b) noexcept { return {_mm512_mul_pd(a.all, b.all)}; }
  friend Lanes fused_multiply_add(Lanes a, Lanes b, Lanes c) noexcept {
    return {_mm512_fmadd_pd(a.all, b.all, c.all)};
  }
#elif defined(__AVX2__) && defined(__FMA__)
  __m256d low, high;

  static Lanes same(double x) noexcept { return {_mm256_set1_pd(x), _mm256_set1_pd(x)}; }
  static Lanes load(const double* x) noexcept { return {_mm256_loadu_pd(x), _mm256_loadu_pd(x + 4)}; }
  void store(double* x) const noexcept {
    _mm256_storeu_pd(x, low);
    _mm256_storeu_pd(x + 4, high);
  }
  template <int Lane>
  Lanes spread() const noexcept {
    const __m256d one = _mm256_permute4x64_pd(Lane < 4 ? low : high, (Lane % 4) * 0x55);
    return {one, one};
  }
  friend Lanes operator+(Lanes a, Lanes b) noexcept {
    return {_mm256_add_pd(a.low, b.low), _mm256_add_pd(a.high, b.high)};
  }
  friend Lanes operator*(Lanes a, Lanes b) noexcept {
    return {_mm256_mul_pd(a.low, b.low), _mm256_mul_pd(a.high, b.high)};
  }
  friend Lanes fused_multiply_add(Lanes a, Lanes b, Lanes c) noexcept {
    return {_mm256_fmadd_pd(a.low, b.low, c.low), _mm256_fmadd_pd(a.high, b.high, c.high)};
  }
#else
  double lane[kCount];

  template <class F>
  static Lanes each(F f) noexcept {
    Lanes result;
    for (int i = 0; i < kCount; ++i) result.lane[i] = f(i);
    return result;
  }
  static Lanes same(double x) noexcept {
    return each([x](int) { return x; });
  }
  static Lanes load(const double* x) noexcept {
    return each([x](int i) { return x[i]; });
  }
  void store(double* x) const noexcept {
    for (int i = 0; i < kCount; ++i) x[i] = lane[i];
  }
  template <int Lane>
  Lanes spread() const noexcept {
    return same(lane[Lane]);
  }
  friend Lanes operator+(const Lanes& a, const Lanes& b) noexcept {
    return each([&](int i) { return a.lane[i] + b.lane[i]; });
  }
  friend Lanes operator*(const Lanes& a, const Lanes& b) noexcept {
    return each([&](int i) { return a.lane[i] * b.lane[i]; });
  }
  friend Lanes fused_multiply_add(const Lanes& a, const Lanes& b, const Lanes& c) noexcept {
    return each([&](int i) { return tactus::fused_multiply_add(a.lane[i], b.lane[i], c.lane[i]); });
  }
#endif
};

/// For the short runs of signals, which would wait longer for the library's copy than for their samples.
inline void copy_samples(const double* from, int count, double* to) noexcept {
  int n = 0;
  for (; n + Lanes::kCount <= count; n += Lanes::kCount) Lanes::load(from + n).store(to + n);
  for (; n < count; ++n) to[n] = from[n];
}

}  // namespace tactus
