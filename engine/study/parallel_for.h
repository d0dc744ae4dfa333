#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace tactus {

/// [control] Calls work(0) … work(count - 1), each once, on all cores, or on as many as `workers` says;
/// `done(share)` is heard on this thread. The calls must not touch the same data.
template <class Work, class Done>
void on_all_cores(int count, const Work& work, const Done& done, int workers = 0) {
  std::atomic<int> next{0}, finished{0};
  const auto labour = [&](bool tells) {
    for (int i = next++; i < count; i = next++) {
      work(i);
      ++finished;
      if (tells) done(static_cast<double>(finished) / count);
    }
  };
  std::vector<std::thread> helpers;
  const int cores =
      workers > 0 ? workers : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  for (int i = 1; i < std::min(cores, count); ++i) helpers.emplace_back(labour, false);
  labour(true);
  for (auto& helper : helpers) helper.join();
  if (count > 0) done(1.0);  // this thread may have come too late for any of them
}

}  // namespace tactus
