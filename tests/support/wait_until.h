#pragma once

#include <chrono>
#include <thread>

namespace tactus::test {

/// For what another process does in its own time: true as soon as `holds()` does, false when it does not
/// within `patience`, which is long: only what never happens may fail, not what a busy machine does late.
template <class Condition>
bool wait_until(Condition holds, std::chrono::milliseconds patience = std::chrono::seconds{30}) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  return true;
}

}  // namespace tactus::test
