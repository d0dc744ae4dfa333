#pragma once

#include <cstdint>

namespace tactus::test {

/// How often `operator new` was called on this thread. The test program replaces it
/// (allocation_count_test.cpp).
std::int64_t allocation_count() noexcept;

}  // namespace tactus::test
