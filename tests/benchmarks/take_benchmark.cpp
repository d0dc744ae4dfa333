#include <benchmark/benchmark.h>

#include <vector>

#include "backends/take/take_recorder.h"

namespace {

using namespace tactus;

/// What recording adds to a block on the audio thread. Time is per block; items are samples.
void take_tap(benchmark::State& state) {
  const auto frames = static_cast<int>(state.range(0));
  const auto channels = static_cast<int>(state.range(1));  // in, and as many out
  TakeRing ring{channels, channels, 5 * 48000};
  std::vector<double> samples(static_cast<std::size_t>(frames), 0.25);
  const std::vector<const double*> in(static_cast<std::size_t>(channels), samples.data());
  const std::vector<double*> out(static_cast<std::size_t>(channels), samples.data());
  std::int64_t frame = 0;
  for (auto _ : state) {
    ring.observe({in.data(), out.data(), frames}, frame);
    frame += frames;
    ring.drop_front(frames);  // what the writer does, without its file
  }
  state.SetItemsProcessed(state.iterations() * frames * channels * 2);
}
BENCHMARK(take_tap)->ArgNames({"frames", "channels"})->ArgsProduct({{16, 64, 256, 1024}, {1, 2, 8, 64}});

}  // namespace
