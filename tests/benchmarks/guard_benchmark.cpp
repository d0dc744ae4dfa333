#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "engine/guard/drive_guard.h"

namespace {

using tactus::DriveLimits;
using tactus::Seconds;

constexpr tactus::Hertz kRate{48e3};

/// Every stage of a drive, with figures like those of a woofer.
DriveLimits all_limits() {
  DriveLimits limits{.ceiling = 0.9, .slew_per_second = 20e3, .soft_start = Seconds{0}};
  limits.heat = tactus::HeatLimits{.watts_at_full_scale = 15, .watts_for_ever = 20, .coil_time = Seconds{8}};
  limits.excursion = tactus::ExcursionLimits{
      .metres = 6e-3, .metres_at_full_scale = 9e-3, .resonance = tactus::Hertz{27}, .q = 0.9};
  limits.dc = {0.4, Seconds{10}};
  return limits;
}

enum Signal {
  Within,   ///< a tone that no stage has anything to do with
  Ceiling,  ///< the same beyond the ceiling
  Travel,   ///< at the resonance, held back by the travel limit
  Hot,      ///< within all limits but that of heat
};

/// What the last stage costs a drive channel. Time is per block; items are frames.
void drive_guard(benchmark::State& state) {
  const auto frames = static_cast<int>(state.range(0));
  const auto signal = static_cast<Signal>(state.range(1));
  auto limits = state.range(2) != 0 ? all_limits() : DriveLimits{};
  tactus::DriveGuard guard{tactus::DriveGuard::Kind::Drive, limits, kRate};
  guard.set_open(true, 0);
  if (signal == Hot) guard.warm_to({0.9, 0.5});
  const double size = signal == Ceiling ? 1.2 : signal == Travel ? 0.8 : 0.3;
  const double hz = signal == Travel ? 27.0 : 187.5;  // 256 frames
  std::vector<double> tone(static_cast<std::size_t>(48'000));
  for (std::size_t n = 0; n < tone.size(); ++n)
    tone[n] = size * std::sin(2 * 3.141592653589793 * hz * static_cast<double>(n) / kRate.value);
  std::vector<double> samples(static_cast<std::size_t>(frames));
  std::int64_t frame = 0;
  std::size_t at = 0;
  for (auto _ : state) {
    if (at + samples.size() > tone.size()) at = 0;
    std::copy_n(tone.data() + at, frames, samples.data());
    at += samples.size();
    guard.process(samples.data(), frames, frame);
    frame += frames;
    if (guard.take_feedback()) guard.set_open(true, frame);
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(frame);
  state.counters["ns/frame"] = benchmark::Counter(static_cast<double>(frame) * 1e-9,
                                                  benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(drive_guard)
    ->ArgNames({"frames", "signal", "models"})
    ->ArgsProduct({{1, 16, 64, 1024}, {Within}, {0, 1}});
BENCHMARK(drive_guard)
    ->ArgNames({"frames", "signal", "models"})
    ->ArgsProduct({{64}, {Ceiling, Travel, Hot}, {1}});

}  // namespace
