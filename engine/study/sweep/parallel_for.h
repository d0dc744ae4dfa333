#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace tactus {

/// [control] Calls work(0) … work(count - 1), each once, on all cores or on `workers` threads; calls
/// `progress(share)` on this thread. The calls must not touch the same data.
template <class Work, class Progress>
void parallel_for(int count, const Work& work, const Progress& progress, int workers = 0) {
  std::atomic<int> next{0}, finished{0};
  const auto run = [&](bool reports) {
    for (int i = next++; i < count; i = next++) {
      work(i);
      ++finished;
      if (reports) progress(static_cast<double>(finished) / count);
    }
  };
  std::vector<std::thread> helpers;
  const int cores =
      workers > 0 ? workers : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  for (int i = 1; i < std::min(cores, count); ++i) helpers.emplace_back(run, false);
  run(true);
  for (auto& helper : helpers) helper.join();
  if (count > 0) progress(1.0);
}

}  // namespace tactus
