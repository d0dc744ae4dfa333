#pragma once
// Thread: [control]

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/units.h"
#include "latency/estimation/fourier.h"
#include "latency/path/path_model.h"
#include "latency/probe/probe.h"

namespace tactus {

/// What is captured while nothing is played.
struct NoiseFloor {
  double mean = 0.0;              ///< DC
  double variance = 0.0;          ///< without DC
  std::vector<double> per_frame;  ///< power spectrum of one frame of it, from 0 to half the sample rate; its
                                  ///< mean is `variance`

  /// [control] By Welch's method, in windows of 1024 frames. A signal shorter than two of them has a flat
  /// spectrum.
  static NoiseFloor of(std::span<const double> quiet);
  /// [any] The power that `frames` frames of it have in each bin of a transform of `size`.
  std::vector<double> in_bins(std::size_t size, double frames) const;
};

/// One repeated burst as it was captured, beside what was expected.
struct TrackedProbe {
  Burst burst;
  double delay_frames = 0.0;
  double deviation_frames = 0.0;  ///< as the noise makes it
  double log_gain = 0.0;
  double gain_deviation = 0.0;  ///< of the log gain, as the noise makes it
  double misfit = 0.0;
  double chi_squared = 1.0;
};

/// A repeated burst in time, from `begin` of the recording that played on, as a burst of gain 1.
struct ProbeInTime {
  std::int64_t begin = 0;
  std::vector<double> captured, expected;
};

/// [control] The median of one of their values.
double usual(double TrackedProbe::*of, const std::vector<TrackedProbe>& probes);

/// [any] Of all of them together, where one at full level has 1.
double total_power(std::span<const TrackedProbe> probes);

/// Cuts what was captured of the repeated bursts out of a recording, and fits the path to it.
class ProbeWindows {
 public:
  /// [control] `profile`: taps of the path, or empty.
  ProbeWindows(const PlayedBursts& bursts, Hertz sample_rate, std::span<const double> profile);

  /// [control] What is only noise; its spectrum must not be zero anywhere.
  void set_noise(const NoiseFloor& floor);
  /// [control] The noise as it is while bursts sound: what differs between those of one gain, of at least
  /// two. A gain that moves is none.
  void set_noise_of(std::span<const double> captured, std::int64_t frames,
                    std::span<const TrackedProbe> which);

  /// [control] Each burst by itself, cut out at the delay `near` and compared with `expected`, what a burst
  /// of gain 1 should look like there: how much later it is (first to the frame within `search`, then
  /// exactly) and how much stronger.
  std::vector<TrackedProbe> track(std::span<const Burst> bursts, std::span<const double> captured,
                                  std::int64_t near, std::int64_t search, const Spectrum& expected);
  /// [control] What a burst looks like behind a path of that model.
  Spectrum expected(const PathModel& model) const;
  /// [control] What it looked like, each frequency as far as it stands out of the noise (Wiener's filter).
  static Spectrum cleaned(const CapturedWindow& window);
  /// [control] Whole frames and gain from which a fit of `window` may start. Bands count by signal over
  /// noise, up to 1 / `clearest`.
  PathModel start_of(const CapturedWindow& window, double sign, std::int64_t search, double clearest = 0.0);
  /// [control] The mean of the bursts `which`, all cut out at the delay `frames`, for a burst of gain 1.
  CapturedWindow mean(std::span<const double> captured, std::int64_t frames,
                      std::span<const TrackedProbe> which);
  /// [control] One burst, cut out at the delay `frames`, for a burst of gain 1.
  Spectrum one(std::span<const double> captured, std::int64_t frames, const Burst& burst);
  /// [control] The variances of a frame that differs between each of the bursts and their mean, of at least
  /// two.
  std::vector<double> scatter(std::span<const double> captured, std::int64_t frames,
                              std::span<const TrackedProbe> which, const CapturedWindow& mean);
  /// [control] A burst, cut out at the delay `frames`, beside the mean of all at its gain.
  ProbeInTime in_time(std::span<const double> captured, std::int64_t frames, const TrackedProbe& probe,
                      const CapturedWindow& mean);

  Fourier& fourier() { return fourier_; }

 private:
  Spectrum cut(std::span<const double> captured, std::int64_t from);
  CapturedWindow window_of(Spectrum captured, double gain) const;
  std::int64_t nearest(const CapturedWindow& window, const Spectrum& expected, std::int64_t search,
                       double clearest);

  Hertz sample_rate_;
  std::int64_t lead_, frames_;
  std::vector<double> fade_;  ///< over the window: 0 at its ends, 1 wherever the burst may be
  double fade_power_ = 0.0;   ///< sum of its squares
  double mean_ = 0.0;         ///< of what is captured while nothing is played
  Fourier fourier_;
  Spectrum played_, profile_;
  std::vector<double> noise_;
  double least_noise_ = 0.0;
  std::size_t lowest_bin_;
};

}  // namespace tactus
