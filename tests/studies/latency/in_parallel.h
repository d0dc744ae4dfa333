#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <thread>
#include <vector>

namespace tactus::study {

/// Calls `trial` for 0 … count - 1 on every core. What a trial does depends on its number alone.
inline void in_parallel(int count, const std::function<void(int)>& trial) {
  std::atomic<int> next{0};
  std::vector<std::jthread> threads;
  for (unsigned t = 0; t < std::max(1u, std::thread::hardware_concurrency()); ++t)
    threads.emplace_back([&] {
      for (int n = next++; n < count; n = next++) trial(n);
    });
}

}  // namespace tactus::study
