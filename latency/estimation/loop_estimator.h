#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "latency/estimation/analysis.h"
#include "latency/estimation/coarse.h"
#include "latency/estimation/delay_trend.h"
#include "latency/estimation/loop_recording.h"
#include "latency/estimation/sweep_windows.h"
#include "latency/path/noise_floor.h"
#include "latency/path/path_model.h"
#include "latency/probe/bursts.h"

namespace tactus {

/// Finds the path in a recording, step by step: where the probe is heard, what is noise, how the clocks
/// drift, the model of the path, and every sweep beside it. Each step needs those above it.
class LoopEstimator {
 public:
  static constexpr double kFits = 0.02;  ///< misfit of a path that the model describes

  /// [control] `recording` and `settings` outlive it.
  LoopEstimator(const LoopRecording& recording, const AnalysisSettings& settings, PlayedBursts bursts);

  /// [control] Whether anything is heard. Bursts that were not recorded as a whole are forgotten; of three
  /// and more, three have to be left.
  bool find();
  /// [control] Takes the drift between the clocks off what was heard.
  void follow_clock();
  /// [control] Whether there is a path behind what was found.
  bool fit();
  /// [control] Each sweep beside what the path makes of it.
  void compare_sweeps();
  /// [control] What is heard of the probe on every input.
  std::vector<CoarseDelay> every_channel();
  /// [control] For more of what was played, in recordings as long as `heard`.
  CoarseSearch& search() { return search_; }

  /// [any] The delay of what was played at `frame`, when it is `constant` once the drift is taken off.
  double as_heard(double constant, double frame) const { return (frame + constant) * speed - frame; }
  /// [any] The delay once the drift is taken off.
  double constant() const { return static_cast<double>(at) + fitted.model.delay_frames; }
  std::span<const double> profile_taps() const;
  Hertz rate() const { return recording.sample_rate; }

  const LoopRecording& recording;
  const AnalysisSettings& settings;
  PlayedBursts bursts;
  std::span<const double> heard;
  SweepWindows windows;

  CoarseDelay coarse;
  bool cut_short = false;  ///< it is heard, but too few bursts as a whole
  NoiseFloor floor;
  double speed = 1.0;                    ///< of the input's clock, in frames that were played
  std::span<const double> steady_heard;  ///< at the speed of what was played
  std::vector<TrackedSweep> steady;      ///< the longest stretch of whole sweeps without a step
  std::int64_t at = 0;                   ///< whole frames of the delay
  HeardWindow mean;                      ///< of the steady sweeps
  PathFit fitted;
  double noise = 0.0;                ///< variance of a frame
  std::vector<TrackedSweep> sweeps;  ///< all of them, beside the path
  std::vector<DelayStep> steps;
  bool overdriven = false;  ///< loud and soft sweeps differ in shape
  DelayTrend trend;

 private:
  NoiseFloor quiet() const;
  void listen_to_quiet();
  Spectrum loudest_sweep();
  std::int64_t reach() const;
  PathFit fit_of(const HeardWindow& window);
  Spectrum expected(const HeardWindow& window, const PathFit& fit) const;
  double middle_delay() const;
  void find_steps(const std::vector<TrackedSweep>& whole);
  void find_damage();

  CoarseSearch search_;
  std::vector<double> steadied_;
};

}  // namespace tactus
