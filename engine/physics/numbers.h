#pragma once

// Thread: [any]
#include <cstddef>
#include <new>
#include <vector>

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

}  // namespace tactus
