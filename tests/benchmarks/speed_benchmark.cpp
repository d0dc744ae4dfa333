#include "tests/benchmarks/speed_benchmark.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <functional>
#include <vector>

#include "engine/core/realtime.h"
#include "tests/benchmarks/peers.h"
#include "tests/benchmarks/speed_report.h"

namespace tactus::bench {
namespace {

using MakePeer = std::function<std::unique_ptr<Peer>(const Work&, const Channels&)>;

/// One iteration plays the tape once. Everybody runs without denormals.
void play(benchmark::State& state, const Work& work, const MakePeer& make, int block) {
  const auto peer = make(work, excitation(work, kTapeFrames));
  const NoDenormals no_denormals;
  const auto tape = [&] {
    for (int frame = 0; frame < kTapeFrames; frame += block) peer->run(frame, block);
    benchmark::ClobberMemory();
  };
  tape();
  for (auto _ : state) tape();
  state.SetItemsProcessed(state.iterations() * kTapeFrames);
}

void add(const Work& work, const std::string& who, MakePeer make) {
  for (const int block : kBlocks)
    benchmark::RegisterBenchmark((work.name + "/" + who + "/" + std::to_string(block)).c_str(),
                                 [=](benchmark::State& state) { play(state, work, make, block); });
}

template <class SomePeer>
MakePeer maker() {
  return [](const Work& work, const Channels& in) { return std::make_unique<SomePeer>(work, in); };
}

/// A work that cannot be exported has no row; why is printed.
void add_exported(const Work& work) {
  try {
    const auto program = std::make_shared<ExportedProgram>(loaded(work));
    add(work, "exported C", [program](const Work& w, const Channels& in) {
      return std::make_unique<ExportedPeer>(*program, w, in);
    });
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: not exported: {}\n", work.name, error.what());
  }
}

void add_loading(const Work& work) {
  benchmark::RegisterBenchmark(("load, check and compile " + work.name).c_str(),
                               [=](benchmark::State& state) {
                                 for (auto _ : state) benchmark::DoNotOptimize(compiled(work));
                               })
      ->Unit(benchmark::kMillisecond);
}

}  // namespace

void add_speed_benchmarks() {
  for (const auto& work : works()) {
    add(work, "graph", maker<GraphPeer>());
    add(work, "plain C++ double", [](const Work& w, const Channels& in) {
      return std::make_unique<HandPeer<double>>(hand_written_double(w), w, in);
    });
    add(work, "plain C++ float", [](const Work& w, const Channels& in) {
      return std::make_unique<HandPeer<float>>(hand_written_float(w), w, in);
    });
    add_exported(work);
    for (auto* build : FaustBuild::all())
      if (build->work == work.faust)
        add(work, "Faust, " + build->name, [build](const Work& w, const Channels& in) {
          return std::make_unique<FaustPeer>(*build, w, in);
        });
  }
  for (const int masses : {1000, 10000}) add(chain(masses), "graph", maker<GraphPeer>());
  // What an engine costs: alone, with a channel through it, and with the guard behind that.
  const Work empty{.name = "engine", .graph = "empty.toml", .text = {}, .inputs = 0};
  const Work wire{.name = "engine", .graph = "wire.toml", .text = {}};
  add(empty, "empty graph", maker<GraphPeer>());
  add(wire, "one wire", maker<GraphPeer>());
  add(wire, "one wire, guarded", maker<GuardedPeer>());
  for (const auto& work : {works()[0], works()[7], modal_bank(1024), chain(10000)}) add_loading(work);
}

}  // namespace tactus::bench
