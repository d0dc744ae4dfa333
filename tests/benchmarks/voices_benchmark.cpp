#include <benchmark/benchmark.h>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"
#include "tests/support/graphs/voices_graph.h"

namespace {

using namespace tactus;

CompileOptions with(bool vectorise) {
  CompileOptions options;
  options.vectorise = vectorise;
  return options;
}

// 64 strings that share one input. Time is per frame; `ns_per_voice` a frame of one voice.
void voices(benchmark::State& state) {
  constexpr int kVoices = 64;
  const auto frames = static_cast<int>(state.range(0));
  const auto engine =
      test::engine_of(test::voices_graph(kVoices, state.range(1) != 0), with(state.range(2) != 0));
  if (!engine->prepare({48_kHz, 1, 1, frames})) return state.SkipWithError("does not run");
  const auto in = test::noise(frames, 1, -0.1, 0.1);
  std::vector<double> out(in.size());
  const double* const from[] = {in.data()};
  double* const to[] = {out.data()};
  for (auto _ : state) {
    engine->process({from, to, frames});
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * frames);
  state.counters["ns_per_frame"] =
      benchmark::Counter(static_cast<double>(frames) * 1e-9,
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(voices)
    ->ArgNames({"frames", "one_node", "vectorise"})
    ->ArgsProduct({{1, 16, 64, 1024}, {0, 1}, {0, 1}});

void compile_voices(benchmark::State& state) {
  const auto text = test::voices_graph(64, state.range(0) != 0);
  for (auto _ : state)
    benchmark::DoNotOptimize(compile(parse_graph_leniently(text, "voices.toml"), standard_nodes(), {}));
}
BENCHMARK(compile_voices)->ArgName("one_node")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
