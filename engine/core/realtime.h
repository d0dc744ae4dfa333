#pragma once
// Thread: [any]

#include <cstdint>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

/// Marks a function that runs on the audio thread: clang's RealtimeSanitizer then reports every call in it
/// that may block. Written after `noexcept`.
#if defined(__clang__) && __clang_major__ >= 20
#define TACTUS_NONBLOCKING [[clang::nonblocking]]
#else
#define TACTUS_NONBLOCKING
#endif

namespace tactus {

/// Flushes denormals (below 1e-308) to zero on this thread while it exists, then restores the former mode: a
/// decaying filter would otherwise run up to a hundred times slower. Nesting costs almost nothing.
class NoDenormals {
 public:
#if defined(__SSE2__)
  NoDenormals() noexcept : saved_(_mm_getcsr()) {
    if ((saved_ & kZeros) != kZeros) _mm_setcsr(saved_ | kZeros);
  }
  ~NoDenormals() {
    if ((saved_ & kZeros) != kZeros) _mm_setcsr(saved_);
  }
#elif defined(__aarch64__)
  NoDenormals() noexcept {
    asm volatile("mrs %0, fpcr" : "=r"(saved_));
    asm volatile("msr fpcr, %0" ::"r"(saved_ | (std::uint64_t{1} << 24)));
  }
  ~NoDenormals() { asm volatile("msr fpcr, %0" ::"r"(saved_)); }
#else
  NoDenormals() noexcept = default;
  ~NoDenormals() = default;
#endif
  NoDenormals(const NoDenormals&) = delete;
  NoDenormals& operator=(const NoDenormals&) = delete;

 private:
#if defined(__SSE2__)
  static constexpr unsigned kZeros = 0x8040;  // FTZ | DAZ
  unsigned saved_;
#elif defined(__aarch64__)
  std::uint64_t saved_;
#endif
};

/// a * b + c, rounded once where the machine has the instruction. Explicit, because the compiler may not
/// choose by itself (-ffp-contract=off): the result must not depend on the block size.
inline double fused_multiply_add(double a, double b, double c) noexcept {
#if defined(__FMA__) || defined(__aarch64__)
  return __builtin_fma(a, b, c);
#else
  return a * b + c;
#endif
}

}  // namespace tactus
