#pragma once
// Thread: [control]

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "latency/estimation/analysis.h"
#include "latency/estimation/coarse.h"
#include "latency/estimation/delay_trend.h"
#include "latency/estimation/loop_recording.h"
#include "latency/estimation/probe_windows.h"
#include "latency/path/path_model.h"
#include "latency/probe/bursts.h"

namespace tactus {

/// Where the probe was found in a recording, and the noise beside it.
struct LocatedProbes {
  CoarseDelay coarse;
  PlayedBursts bursts;  ///< `repeated`: those that were recorded completely
  NoiseFloor floor;
  bool cut_short = false;  ///< found, but with too few complete bursts: of three and more, three are needed
  bool usable() const { return coarse.found() && !cut_short; }
};

/// The recording at the speed of the clock that played.
struct AlignedClock {
  double speed = 1.0;  ///< of the input's clock, in frames that were played
  std::vector<double> samples;
  std::vector<TrackedProbe> steady;   ///< the longest run of undamaged probes without a step
  std::vector<TrackedProbe> tracked;  ///< all of them, beside the loudest
  CoarseDelay coarse;                 ///< in `samples`
  std::int64_t at = 0;                ///< whole frames of the delay
};

/// The model of the path behind `at`, fitted to the mean of the steady probes.
struct FittedPath {
  std::int64_t at = 0;
  CapturedWindow mean;
  PathFit fit;
  double noise = 0.0;  ///< variance of a frame
  /// False: a tone or a click may correlate with a probe, but no path makes one from the other.
  bool plausible() const;
};

/// Every probe beside what the path makes of it.
struct ComparedProbes {
  std::vector<TrackedProbe> probes;
  std::vector<DelayStep> steps;
  bool overdriven = false;  ///< loud and soft probes differ in shape
  DelayTrend trend;
};

/// What a recording says about the path from output to input. A part is empty where the one before it was not
/// usable; `compared` also where the probes are too weak to be found one by one.
struct LoopEstimate {
  LocatedProbes located;
  AlignedClock clock;
  FittedPath path;
  ComparedProbes compared;
  bool found = false;  ///< a path was found

  /// The delay at constant clock speed.
  double constant() const { return static_cast<double>(path.at) + path.fit.model.delay_frames; }
  /// The delay of what was played at `frame`, where it is `constant` at constant clock speed.
  double captured_delay(double constant, double frame) const {
    return (frame + constant) * clock.speed - frame;
  }
};

/// Estimates the path in a recording. Each step takes the results of those before it and changes nothing but
/// the transforms' work space.
class LoopEstimator {
 public:
  static constexpr double kFits = 0.02;  ///< misfit of a path that the model describes

  /// `recording`, `settings` and `bursts` outlive it.
  LoopEstimator(const LoopRecording& recording, const AnalysisSettings& settings, const PlayedBursts& bursts);

  LoopEstimate estimate();
  /// Where the probe is found on every input.
  std::vector<CoarseDelay> every_channel();

  /// For more of what was played, in recordings as long as this.
  CoarseSearch& search() { return search_; }
  ProbeWindows& windows() { return windows_; }
  const LoopRecording& recording() const { return recording_; }
  const AnalysisSettings& settings() const { return settings_; }
  std::span<const double> captured() const { return captured_; }
  Hertz rate() const { return recording_.sample_rate; }

 private:
  LocatedProbes locate();
  AlignedClock align(const LocatedProbes& located);
  FittedPath fit(const LocatedProbes& located, const AlignedClock& clock);
  ComparedProbes compare(const LoopEstimate& estimate);

  NoiseFloor quiet(const CoarseDelay& coarse) const;
  NoiseFloor noise_floor(const CoarseDelay& coarse) const;
  Spectrum loudest_probe(const LocatedProbes& located, const AlignedClock& clock);
  PathFit fit_of(const CapturedWindow& window, const CoarseDelay& coarse);
  Spectrum expected(const CapturedWindow& window, const PathFit& fit) const;
  void add_pilot_steps(const LoopEstimate& estimate, const Burst& pilot,
                       const std::vector<TrackedProbe>& whole, std::vector<DelayStep>& steps) const;
  void find_damage(const LoopEstimate& estimate, ComparedProbes& compared);
  std::span<const double> profile_taps() const;

  const LoopRecording& recording_;
  const AnalysisSettings& settings_;
  const PlayedBursts& bursts_;
  std::span<const double> captured_;
  ProbeWindows windows_;
  CoarseSearch search_;
};

}  // namespace tactus
