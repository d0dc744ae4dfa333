#pragma once

#include <cstdint>
#include <vector>

namespace tactus {

/// [control] Of the numbers 0 … count - 1: where runs begin for which `broken` holds, of at most `longest`.
template <class Broken>
std::vector<std::int64_t> short_runs(std::int64_t count, std::int64_t longest, const Broken& broken) {
  std::vector<std::int64_t> begins;
  std::int64_t run = 0;
  for (std::int64_t n = 0; n <= count; ++n) {
    const bool here = n < count && broken(n);
    if (!here && run > 0 && run <= longest) begins.push_back(n - run);
    run = here ? run + 1 : 0;
  }
  return begins;
}

}  // namespace tactus
