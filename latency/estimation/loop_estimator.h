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
#include "latency/estimation/pilot_track.h"
#include "latency/estimation/probe_windows.h"
#include "latency/path/delay_error.h"
#include "latency/path/path_model.h"
#include "latency/probe/probe.h"

namespace tactus {

/// What a recording says about the path from output to input, found part by part; what follows a part that
/// was not usable is empty.
struct LoopEstimate {
  // Where the probe was found, and the noise beside it.
  CoarseDelay coarse;   ///< in `samples`
  PlayedBursts bursts;  ///< `repeated`: those that were recorded completely
  NoiseFloor floor;
  bool cut_short = false;  ///< found, but with too few complete bursts: of three and more, three are needed

  // The recording at the speed of the clock that played.
  double speed = 1.0;  ///< of the input's clock, in frames that were played
  std::vector<double> samples;
  std::vector<TrackedProbe> steady;  ///< the longest run of undamaged probes without a step

  // The model of the path behind `at`, fitted to the mean of the steady probes.
  bool found = false;   ///< a path was found
  std::int64_t at = 0;  ///< whole frames of the delay
  CapturedWindow mean;
  PathFit fit;
  double noise = 0.0;               ///< variance of a frame
  bool unsteady = false;            ///< noise that is far louder at one time than at another
  std::optional<DelayError> error;  ///< of at least four probes

  // Every probe beside what the path makes of it; where they are too weak to be found one by one, beside the
  // loudest.
  std::vector<TrackedProbe> probes;
  std::vector<DelayStep> steps;
  bool overdriven = false;  ///< loud and soft probes differ in shape
  double least_step = 0.0;  ///< frames: fewer that are lost between two probes are not certain to be detected
  bool ends_hidden = false;  ///< frames lost before the first probe or behind the last are not known
  DelayTrend trend;

  /// The delay at constant clock speed.
  double constant() const { return static_cast<double>(at) + fit.model.delay_frames; }
  /// The delay of what was played at `frame`, where it is `constant` at constant clock speed.
  double captured_delay(double constant, double frame) const { return (frame + constant) * speed - frame; }
  /// [control] `samples` less the mean of the silence.
  std::vector<double> without_dc() const;
};

/// Estimates the path in a recording. Each step adds its part to the estimate.
class LoopEstimator {
 public:
  static constexpr double kFits = 0.02;  ///< misfit of a path that the model describes

  /// All three outlive it.
  LoopEstimator(const LoopRecording& recorded, const AnalysisSettings& asked, const PlayedBursts& bursts);

  LoopEstimate estimate();

  const LoopRecording& recording;
  const AnalysisSettings& settings;
  const Hertz rate;
  const std::span<const double> captured;
  const std::span<const double> profile;  ///< taps; empty: a cable
  ProbeWindows windows;
  CoarseSearch search;  ///< for more of what was played, in recordings as long as this

 private:
  void locate(LoopEstimate& loop);
  void align(LoopEstimate& loop);
  void fit(LoopEstimate& loop);
  void estimate_noise(LoopEstimate& loop, bool by_probes);
  void compare(LoopEstimate& loop);

  NoiseFloor quiet(const CoarseDelay& coarse) const;
  NoiseFloor noise_floor(const CoarseDelay& coarse) const;
  Spectrum loudest_probe(const LoopEstimate& loop);
  PathFit fit_of(const CapturedWindow& window, const CoarseDelay& coarse);
  Spectrum expected(const CapturedWindow& window, const PathFit& fit) const;
  SingleBurst single(const LoopEstimate& loop, const Burst& burst, std::int64_t at) const;
  void add_mark_steps(LoopEstimate& loop, const Burst& mark, const std::vector<TrackedProbe>& whole) const;
  void add_pilot_steps(LoopEstimate& loop, const Burst& pilot, const std::vector<TrackedProbe>& whole) const;
  void find_damage(LoopEstimate& loop);

  const PlayedBursts& bursts_;
};

}  // namespace tactus
