#include <benchmark/benchmark.h>

#include <vector>

#include "engine/core/drive_guard.h"

namespace {

// What the last stage costs a drive channel, at the block sizes of docs/design.md. Time is per frame.
void drive_guard(benchmark::State& state) {
  const auto frames = static_cast<int>(state.range(0));
  tactus::DriveLimits limits;
  if (state.range(1) != 0) limits.slew_per_second = 4800.0;
  tactus::DriveGuard guard{tactus::DriveGuard::Kind::Drive, limits, tactus::Hertz{48e3}};
  guard.set_open(true, 0);
  std::vector<double> samples(static_cast<std::size_t>(frames), 0.05);
  std::int64_t frame = 0;
  for (auto _ : state) {
    guard.process(samples.data(), frames, frame);
    frame += frames;
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(frame);
}
BENCHMARK(drive_guard)->ArgNames({"frames", "slew"})->ArgsProduct({{1, 16, 64, 1024}, {0, 1}});

}  // namespace
