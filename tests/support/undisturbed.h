#pragma once

#include <iostream>
#include <optional>
#include <string>

#include "tests/support/skip.h"

namespace tactus::test {

/// For a measurement that only counts where the machine was fast enough. `measure()` does it and checks
/// nothing; it returns its result, or nothing when it detected that the machine disturbed it. It is then
/// repeated, at most five times; each time is reported, and when all were disturbed the test case is skipped.
template <class Measure>
auto undisturbed(const std::string& what, Measure measure) {
  constexpr int kAttempts = 5;
  for (int attempt = 1; attempt <= kAttempts; ++attempt) {
    if (auto result = measure()) return *std::move(result);
    std::cout << "disturbed by the machine, attempt " << attempt << " of " << kAttempts << ": " << what
              << std::endl;
  }
  skip("this machine is too busy: " + what + " in each of " + std::to_string(kAttempts) + " attempts");
}

}  // namespace tactus::test
