#pragma once

// Thread: [any].

#include <cstddef>

#include "engine/core/realtime.h"
#include "engine/dsp/kernel.h"

#if defined(__AVX512F__) || (defined(__AVX2__) && defined(__FMA__))
#include <immintrin.h>
#endif

namespace tactus {

/// Eight doubles in one or two vector registers. Written out for the vector units because compilers turn a
/// loop of eight fused multiply-adds into eight scalar ones; every variant rounds alike, so the bits are the
/// same on all machines that have the instruction.
struct Lanes {
  static constexpr int kCount = 8;

#if defined(__AVX512F__)
  static constexpr bool kInRegisters = true;
  __m512d all;

  static Lanes broadcast(double x) noexcept { return {_mm512_set1_pd(x)}; }
  static Lanes load(const double* x) noexcept { return {_mm512_loadu_pd(x)}; }
  /// A number from each of kCount places, `offset` behind each.
  static Lanes gather(const double* const* x, std::ptrdiff_t offset) noexcept {
    return {_mm512_set_pd(x[7][offset], x[6][offset], x[5][offset], x[4][offset], x[3][offset], x[2][offset],
                          x[1][offset], x[0][offset])};
  }
  void store(double* x) const noexcept { _mm512_storeu_pd(x, all); }
  /// One lane in every lane.
  template <int Lane>
  Lanes spread() const noexcept {
    return {__builtin_shufflevector(all, all, Lane, Lane, Lane, Lane, Lane, Lane, Lane, Lane)};
  }
  /// Every lane from the one below it; the lowest from the highest of `before`.
  Lanes moved_up(Lanes before) const noexcept {
    return {__builtin_shufflevector(before.all, all, 7, 8, 9, 10, 11, 12, 13, 14)};
  }
  /// Every lane from the one above it; the highest from the lowest of `after`.
  Lanes moved_down(Lanes after) const noexcept {
    return {__builtin_shufflevector(all, after.all, 1, 2, 3, 4, 5, 6, 7, 8)};
  }
  friend Lanes operator+(Lanes a, Lanes b) noexcept { return {_mm512_add_pd(a.all, b.all)}; }
  friend Lanes operator-(Lanes a, Lanes b) noexcept { return {_mm512_sub_pd(a.all, b.all)}; }
  friend Lanes operator*(Lanes a, Lanes b) noexcept { return {_mm512_mul_pd(a.all, b.all)}; }
  /// As std::max and std::min, lane by lane.
  friend Lanes max(Lanes a, Lanes b) noexcept { return {_mm512_maskz_max_pd(0xff, b.all, a.all)}; }
  friend Lanes min(Lanes a, Lanes b) noexcept { return {_mm512_maskz_min_pd(0xff, b.all, a.all)}; }
  /// `yes` where a > b, else 0.
  friend Lanes where_above(Lanes a, Lanes b, Lanes yes) noexcept {
    return {_mm512_maskz_mov_pd(_mm512_cmp_pd_mask(a.all, b.all, _CMP_GT_OQ), yes.all)};
  }
  friend Lanes fused_multiply_add(Lanes a, Lanes b, Lanes c) noexcept {
    return {_mm512_fmadd_pd(a.all, b.all, c.all)};
  }
  /// A bit for each lane of a that is b or more; NaN is not.
  friend int at_least(Lanes a, Lanes b) noexcept { return _mm512_cmp_pd_mask(a.all, b.all, _CMP_GE_OQ); }
  /// Every lane is 0; NaN is not.
  bool all_zero() const noexcept { return _mm512_cmp_pd_mask(all, _mm512_setzero_pd(), _CMP_NEQ_UQ) == 0; }
  /// All lanes added in halves: k and k + 4, k and k + 2, k and k + 1.
  double sum() const noexcept {
    const __m256d half =
        __builtin_shufflevector(all, all, 0, 1, 2, 3) + __builtin_shufflevector(all, all, 4, 5, 6, 7);
    const __m128d pair =
        __builtin_shufflevector(half, half, 0, 1) + __builtin_shufflevector(half, half, 2, 3);
    return pair[0] + pair[1];
  }
#elif defined(__AVX2__) && defined(__FMA__)
  static constexpr bool kInRegisters = true;
  __m256d low, high;

  static Lanes broadcast(double x) noexcept { return {_mm256_set1_pd(x), _mm256_set1_pd(x)}; }
  static Lanes load(const double* x) noexcept { return {_mm256_loadu_pd(x), _mm256_loadu_pd(x + 4)}; }
  static Lanes gather(const double* const* x, std::ptrdiff_t offset) noexcept {
    return {_mm256_set_pd(x[3][offset], x[2][offset], x[1][offset], x[0][offset]),
            _mm256_set_pd(x[7][offset], x[6][offset], x[5][offset], x[4][offset])};
  }
  void store(double* x) const noexcept {
    _mm256_storeu_pd(x, low);
    _mm256_storeu_pd(x + 4, high);
  }
  template <int Lane>
  Lanes spread() const noexcept {
    const __m256d one = _mm256_permute4x64_pd(Lane < 4 ? low : high, (Lane % 4) * 0x55);
    return {one, one};
  }
  Lanes moved_up(Lanes before) const noexcept {
    return {__builtin_shufflevector(before.high, low, 3, 4, 5, 6),
            __builtin_shufflevector(low, high, 3, 4, 5, 6)};
  }
  Lanes moved_down(Lanes after) const noexcept {
    return {__builtin_shufflevector(low, high, 1, 2, 3, 4),
            __builtin_shufflevector(high, after.low, 1, 2, 3, 4)};
  }
  friend Lanes operator+(Lanes a, Lanes b) noexcept {
    return {_mm256_add_pd(a.low, b.low), _mm256_add_pd(a.high, b.high)};
  }
  friend Lanes operator-(Lanes a, Lanes b) noexcept {
    return {_mm256_sub_pd(a.low, b.low), _mm256_sub_pd(a.high, b.high)};
  }
  friend Lanes operator*(Lanes a, Lanes b) noexcept {
    return {_mm256_mul_pd(a.low, b.low), _mm256_mul_pd(a.high, b.high)};
  }
  friend Lanes max(Lanes a, Lanes b) noexcept {
    return {_mm256_max_pd(b.low, a.low), _mm256_max_pd(b.high, a.high)};
  }
  friend Lanes min(Lanes a, Lanes b) noexcept {
    return {_mm256_min_pd(b.low, a.low), _mm256_min_pd(b.high, a.high)};
  }
  friend Lanes where_above(Lanes a, Lanes b, Lanes yes) noexcept {
    return {_mm256_and_pd(_mm256_cmp_pd(a.low, b.low, _CMP_GT_OQ), yes.low),
            _mm256_and_pd(_mm256_cmp_pd(a.high, b.high, _CMP_GT_OQ), yes.high)};
  }
  friend Lanes fused_multiply_add(Lanes a, Lanes b, Lanes c) noexcept {
    return {_mm256_fmadd_pd(a.low, b.low, c.low), _mm256_fmadd_pd(a.high, b.high, c.high)};
  }
  friend int at_least(Lanes a, Lanes b) noexcept {
    return _mm256_movemask_pd(_mm256_cmp_pd(a.low, b.low, _CMP_GE_OQ)) |
           _mm256_movemask_pd(_mm256_cmp_pd(a.high, b.high, _CMP_GE_OQ)) << 4;
  }
  bool all_zero() const noexcept {
    const __m256d zero = _mm256_setzero_pd();
    return _mm256_movemask_pd(_mm256_or_pd(_mm256_cmp_pd(low, zero, _CMP_NEQ_UQ),
                                           _mm256_cmp_pd(high, zero, _CMP_NEQ_UQ))) == 0;
  }
  double sum() const noexcept {
    const __m256d half = low + high;
    const __m128d pair =
        __builtin_shufflevector(half, half, 0, 1) + __builtin_shufflevector(half, half, 2, 3);
    return pair[0] + pair[1];
  }
#else
  static constexpr bool kInRegisters = false;
  double lane[kCount];

  template <class F>
  static Lanes each(F f) noexcept {
    Lanes result;
    for (int i = 0; i < kCount; ++i) result.lane[i] = f(i);
    return result;
  }
  static Lanes broadcast(double x) noexcept {
    return each([x](int) { return x; });
  }
  static Lanes load(const double* x) noexcept {
    return each([x](int i) { return x[i]; });
  }
  static Lanes gather(const double* const* x, std::ptrdiff_t offset) noexcept {
    return each([x, offset](int i) { return x[i][offset]; });
  }
  void store(double* x) const noexcept {
    for (int i = 0; i < kCount; ++i) x[i] = lane[i];
  }
  template <int Lane>
  Lanes spread() const noexcept {
    return broadcast(lane[Lane]);
  }
  Lanes moved_up(const Lanes& before) const noexcept {
    return each([&](int i) { return i == 0 ? before.lane[kCount - 1] : lane[i - 1]; });
  }
  Lanes moved_down(const Lanes& after) const noexcept {
    return each([&](int i) { return i + 1 == kCount ? after.lane[0] : lane[i + 1]; });
  }
  friend Lanes operator+(const Lanes& a, const Lanes& b) noexcept {
    return each([&](int i) { return a.lane[i] + b.lane[i]; });
  }
  friend Lanes operator-(const Lanes& a, const Lanes& b) noexcept {
    return each([&](int i) { return a.lane[i] - b.lane[i]; });
  }
  friend Lanes operator*(const Lanes& a, const Lanes& b) noexcept {
    return each([&](int i) { return a.lane[i] * b.lane[i]; });
  }
  friend Lanes max(const Lanes& a, const Lanes& b) noexcept {
    return each([&](int i) { return a.lane[i] < b.lane[i] ? b.lane[i] : a.lane[i]; });
  }
  friend Lanes min(const Lanes& a, const Lanes& b) noexcept {
    return each([&](int i) { return b.lane[i] < a.lane[i] ? b.lane[i] : a.lane[i]; });
  }
  friend Lanes where_above(const Lanes& a, const Lanes& b, const Lanes& yes) noexcept {
    return each([&](int i) { return a.lane[i] > b.lane[i] ? yes.lane[i] : 0.0; });
  }
  friend Lanes fused_multiply_add(const Lanes& a, const Lanes& b, const Lanes& c) noexcept {
    return each([&](int i) { return tactus::fused_multiply_add(a.lane[i], b.lane[i], c.lane[i]); });
  }
  friend int at_least(Lanes a, Lanes b) noexcept {
    int bits = 0;
    for (int i = 0; i < kCount; ++i) bits |= (a.lane[i] >= b.lane[i] ? 1 : 0) << i;
    return bits;
  }
  bool all_zero() const noexcept {
    bool zero = true;
    for (int i = 0; i < kCount; ++i) zero = zero && lane[i] == 0;
    return zero;
  }
  double sum() const noexcept { return tactus_sum_of_eight(lane); }
#endif
};

inline Lanes operator-(Lanes a) noexcept { return Lanes::broadcast(-0.0) - a; }

/// Whether one of the samples, which are finite, is at `level` or above.
inline bool any_at_least(const double* samples, int count, double level) noexcept {
  int found = 0, n = 0;
  for (; n + Lanes::kCount <= count; n += Lanes::kCount)
    found |= at_least(Lanes::load(samples + n), Lanes::broadcast(level));
  for (; n < count; ++n) found |= samples[n] >= level ? 1 : 0;
  return found != 0;
}

/// Whether one of the samples, which are finite, is below `level`.
inline bool any_below(const double* samples, int count, double level) noexcept {
  constexpr int kAll = (1 << Lanes::kCount) - 1;
  int found = 0, n = 0;
  for (; n + Lanes::kCount <= count; n += Lanes::kCount)
    found |= at_least(Lanes::load(samples + n), Lanes::broadcast(level)) ^ kAll;
  for (; n < count; ++n) found |= samples[n] < level ? 1 : 0;
  return found != 0;
}

/// For short blocks, where the library's functions have more overhead than work.
inline void copy_samples(const double* from, int count, double* to) noexcept {
  int n = 0;
  for (; n + Lanes::kCount <= count; n += Lanes::kCount) Lanes::load(from + n).store(to + n);
  for (; n < count; ++n) to[n] = from[n];
}

inline void fill_samples(double* to, int count, double value) noexcept {
  int n = 0;
  for (; n + Lanes::kCount <= count; n += Lanes::kCount) Lanes::broadcast(value).store(to + n);
  for (; n < count; ++n) to[n] = value;
}

}  // namespace tactus
