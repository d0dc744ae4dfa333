#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <vector>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/mostly_idle_graph.h"
#include "tests/support/graphs/node_runner.h"

namespace {

using namespace tactus;

constexpr int kFrames = 64;
constexpr int kBlocks = 50;

/// An engine on noise, timed over kBlocks blocks.
class Timed {
 public:
  explicit Timed(const std::string& text)
      : engine_(test::engine_of(text)),
        in_(test::noise(kFrames, 1)),
        out_(static_cast<std::size_t>(kFrames)) {
    (void)engine_->prepare({48_kHz, 1, 1, kFrames});
  }
  double nanoseconds_a_frame() {
    const double* in[] = {in_.data()};
    double* out[] = {out_.data()};
    const auto before = std::chrono::steady_clock::now();
    for (int block = 0; block < kBlocks; ++block) engine_->process({in, out, kFrames});
    const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - before;
    return took.count() / (kBlocks * kFrames);
  }
  double arena_bytes() const { return static_cast<double>(engine_->plan().arena.size() * sizeof(double)); }

 private:
  std::unique_ptr<Player> engine_;
  std::vector<double> in_, out_;
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

double threads() {
  std::error_code none;
  double count = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task", none))
    count += task.exists();
  return count;
}

// A file of 10,000 nodes of which 12 matter, beside a file of the 12. The two run by turns, and each ratio is
// of neighbours in time, so that what else the machine does meets both. Time is that of the pair.
void leave_out(benchmark::State& state) {
  const double threads_before = threads();
  Timed alone{test::twelve_alone()}, among{test::twelve_among(10'000)};
  std::vector<double> ratios, alone_ns, among_ns;
  bool first = false;
  for (auto _ : state) {
    first = !first;
    const double early = first ? alone.nanoseconds_a_frame() : among.nanoseconds_a_frame();
    const double late = first ? among.nanoseconds_a_frame() : alone.nanoseconds_a_frame();
    alone_ns.push_back(first ? early : late);
    among_ns.push_back(first ? late : early);
    ratios.push_back(among_ns.back() / alone_ns.back());
  }
  state.counters["ratio"] = median(ratios);
  state.counters["alone_ns"] = median(alone_ns);
  state.counters["among_ns"] = median(among_ns);
  state.counters["alone_arena_bytes"] = alone.arena_bytes();
  state.counters["among_arena_bytes"] = among.arena_bytes();
  state.counters["threads_started"] = threads() - threads_before;
}
BENCHMARK(leave_out)->Iterations(2001);

}  // namespace
