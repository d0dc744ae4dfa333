#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "engine/core/index.h"
#include "engine/graph/file/load.h"
#include "engine/graph/plan/compile.h"
#include "engine/nodes/table.h"
#include "engine/runtime/player.h"
#include "engine/runtime/signal_scope.h"

namespace {

using namespace tactus;

constexpr int kBlock = 64;

/// What a scope of so many traces adds to a block of the haptic drum.
void scope(benchmark::State& state) {
  const auto traces = static_cast<std::size_t>(state.range(0));
  auto plan = compile(load_graph_leniently("instruments/haptic_drum/instrument.toml"), standard_nodes(), {});
  if (!plan) return state.SkipWithError("run it in the root of the project");
  Player player{std::move(*plan)};
  SignalScope scope;
  player.add_observer(scope);
  std::vector<SignalPlace> places;
  for (const auto& signal : scope_signals(player.plan()))
    if (places.size() < traces && signal.place.control < 0) places.push_back(signal.place);
  (void)scope.choose(ScopeChoice::of(player.version(), 1, static_cast<int>(state.range(1)), places));
  if (!player.prepare({48_kHz, player.in_channels(), player.out_channels(), kBlock})) return;
  std::vector<std::vector<double>> in(index(player.in_channels()), std::vector<double>(kBlock, 1e-3));
  std::vector<std::vector<double>> out(index(player.out_channels()), std::vector<double>(kBlock));
  std::vector<const double*> from;
  std::vector<double*> to;
  for (const auto& channel : in) from.push_back(channel.data());
  for (auto& channel : out) to.push_back(channel.data());
  const NoDenormals no_denormals;
  ScopeChunk chunk;
  for (auto _ : state) {
    player.process({from.data(), to.data(), kBlock});
    while (scope.take(chunk)) benchmark::DoNotOptimize(chunk.values.data());
  }
  state.counters["share of the block's time"] = benchmark::Counter(
      kBlock / 48e3, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

}  // namespace

BENCHMARK(scope)->ArgNames({"traces", "bin"})->ArgsProduct({{0, 1, 8}, {1, 48}});
