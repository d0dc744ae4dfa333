#pragma once

// Thread: [any]
#include <cstddef>
#include <new>
#include <type_traits>
#include <vector>

#include "engine/dsp/simd/lanes.h"

namespace tactus {

/// Memory from the start of a cache line on: a vector register is then read in one go, not from two lines.
template <class T>
struct CacheLineAllocator {
  using value_type = T;
  static constexpr std::align_val_t kLine{64};

  CacheLineAllocator() = default;
  template <class Other>
  explicit CacheLineAllocator(const CacheLineAllocator<Other>&) noexcept {}
  T* allocate(std::size_t count) { return static_cast<T*>(::operator new(count * sizeof(T), kLine)); }
  void deallocate(T* memory, std::size_t) noexcept { ::operator delete(memory, kLine); }
  friend bool operator==(CacheLineAllocator, CacheLineAllocator) noexcept { return true; }
};

using AlignedNumbers = std::vector<double, CacheLineAllocator<double>>;

constexpr double square(double x) noexcept { return x * x; }

// One source for one number and for a vector of them: the same sums and products in the same order, so
// the results are the same to the bit. All [realtime].

template <class Vector>
Vector load(const double* x) noexcept {
  if constexpr (std::is_same_v<Vector, double>)
    return *x;
  else
    return Vector::load(x);
}
inline void store(double x, double* to) noexcept { *to = x; }
inline void store(const Lanes& x, double* to) noexcept { x.store(to); }

/// What the numbers below have.
inline double moved_up(double, double below) noexcept { return below; }
inline Lanes moved_up(const Lanes& here, const Lanes& below) noexcept { return here.moved_up(below); }

/// What the numbers above have, `next` being where that of the highest is. What was just stored as one
/// register is read as one again: from two halves it would have to wait until both have left for the cache.
inline double moved_down(double, const double* next) noexcept { return *next; }
inline Lanes moved_down(const Lanes& here, const double* next) noexcept {
  return here.moved_down(Lanes::broadcast(*next));
}

inline double highest(const Lanes& x) noexcept {
  double all[Lanes::kCount];
  x.store(all);
  return all[Lanes::kCount - 1];
}

/// How many of `count` numbers are worked on in lanes: without vector registers one by one is faster.
constexpr int in_lanes(int count) noexcept {
  return Lanes::kInRegisters && count > 0 ? count / Lanes::kCount * Lanes::kCount : 0;
}

/// pass.operator()<Vector>(i) for all of `count` numbers, i being the first of a register.
template <class Pass>
void for_all(std::size_t count, Pass pass) noexcept {
  const auto vectorised = static_cast<std::size_t>(in_lanes(static_cast<int>(count)));
  for (std::size_t i = 0; i < vectorised; i += Lanes::kCount) pass.template operator()<Lanes>(i);
  for (std::size_t i = vectorised; i < count; ++i) pass.template operator()<double>(i);
}

/// x_i becomes by_i x_i.
inline void multiply(const double* by, std::size_t count, double* x) noexcept {
  for_all(count,
          [=]<class Vector>(std::size_t i) { store(load<Vector>(x + i) * load<Vector>(by + i), x + i); });
}

}  // namespace tactus
