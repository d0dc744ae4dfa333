#pragma once
// Thread: [control]

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <thread>
#include <vector>

#include "engine/core/error.h"

namespace tactus {

/// Calls work(0) … work(count - 1), each once, on all cores or on `workers` threads; calls
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

/// How the runs of a study are executed.
struct RunPlan {
  int workers = 0;                   ///< threads; 0: one per core
  int part = 0, parts = 1;           ///< only runs whose number is `part` modulo `parts` are executed
  std::filesystem::path cache = {};  ///< folder of finished runs; empty: none
  std::function<void(double)> progress = {};
  std::function<bool()> stop = {};  ///< true: no further run is begun
};

/// What a run gives: any numbers.
using RunResult = std::vector<double>;

/// The results of `count` runs; nullopt: not executed. `evaluate` is called from several threads, for each
/// run that is not in the cache; `key` identifies a run there. The results depend neither on the number of
/// workers nor on interruptions. Errors: the first one of `evaluate`; BadFile of the cache.
///
/// The cache is a folder of files *.jsonl with a line for each run, {"key": "9f8a…", "run": [0.5, null, …]};
/// null is a non-finite number. Every program that works on the same study writes a file of its own and reads
/// all. An incomplete last line is ignored, and its run is executed again.
Checked<std::vector<std::optional<RunResult>>> evaluate_runs(
    const RunPlan& plan, int count, const std::function<std::uint64_t(int)>& key,
    const std::function<Checked<RunResult>(int)>& evaluate);

}  // namespace tactus
