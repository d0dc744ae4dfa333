#include "tests/support/allocation_count.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <new>

#ifdef _WIN32
#include <malloc.h>
#endif

namespace {

thread_local std::int64_t allocations = 0;
std::atomic<std::int64_t> live{0};

#ifdef _WIN32
void* take_memory(std::size_t bytes, std::size_t alignment) {
  return ::_aligned_malloc(bytes > 0 ? bytes : 1, std::max(alignment, alignof(std::max_align_t)));
}
void give_back(void* memory) noexcept { ::_aligned_free(memory); }
#else
void* take_memory(std::size_t bytes, std::size_t alignment) {
  // aligned_alloc wants a size that is a multiple of the alignment; malloc knows no size of zero.
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  return alignment <= alignof(std::max_align_t)
             ? std::malloc(bytes > 0 ? bytes : 1)
             : std::aligned_alloc(alignment, rounded > 0 ? rounded : alignment);
}
void give_back(void* memory) noexcept { std::free(memory); }
#endif

void* allocate(std::size_t bytes, std::size_t alignment) {
  ++allocations;
  void* const memory = take_memory(bytes, alignment);
  if (memory == nullptr) throw std::bad_alloc{};
  live.fetch_add(1, std::memory_order_relaxed);
  return memory;
}

/// Not inlined: gcc would see `free` on what a new-expression returned, and warn.
[[gnu::noinline]] void release(void* memory) noexcept {
  if (memory != nullptr) live.fetch_sub(1, std::memory_order_relaxed);
  give_back(memory);
}

}  // namespace

// The array and nothrow forms of the library would call the first two; those of ThreadSanitizer do not.
void* operator new(std::size_t bytes) { return allocate(bytes, 1); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return allocate(bytes, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t bytes) { return allocate(bytes, 1); }
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept { return allocate(bytes, 1); }
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept { return allocate(bytes, 1); }
void operator delete[](void* memory) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t) noexcept { release(memory); }
void operator delete(void* memory) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }

namespace tactus::test {

std::int64_t allocation_count() noexcept { return allocations; }
std::int64_t live_allocations() noexcept { return live.load(std::memory_order_relaxed); }

}  // namespace tactus::test

TEST_CASE("allocation_count: sees every form of new", "[conformance]") {
  // Functions, not new-expressions: the compiler may leave those out.
  const auto before = tactus::test::allocation_count();
  ::operator delete(::operator new(8));
  CHECK(tactus::test::allocation_count() == before + 1);
  ::operator delete[](::operator new[](8, std::nothrow));
  CHECK(tactus::test::allocation_count() == before + 2);
  ::operator delete (::operator new (8, std::align_val_t{64}), std::align_val_t{64});
  CHECK(tactus::test::allocation_count() == before + 3);
}
