#pragma once

#include <cstdint>

namespace tactus::test {

/// How often `operator new` was called on this thread. The test program replaces it
/// (allocation_count_test.cpp).
std::int64_t allocation_count() noexcept;

/// Pieces of memory that `operator new` gave and nobody has given back yet, over all threads.
std::int64_t live_allocations() noexcept;

}  // namespace tactus::test
