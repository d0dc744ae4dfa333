#pragma once
// Thread: [control] unless stated otherwise

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/units.h"
#include "latency/estimation/fourier.h"
#include "latency/path/path_model.h"

namespace tactus {

/// Where what was played is captured, to the frame.
struct CoarseDelay {
  std::int64_t frames = 0;  ///< negative: the recording began after the probe
  double sign = 1.0;
  /// How far the correlation at that delay exceeds that at other delays, in standard deviations.
  /// Without any signal its highest value among n delays is about sqrt(2 ln n): 5 for a few hundred thousand.
  double prominence = 0.0;

  static constexpr double kClear = 24.0;
  static constexpr double kNothing = 8.0;  ///< below it nothing was captured: chance exceeds it once in 10^9
  bool found() const { return prominence >= kNothing; }
  /// Strong enough that every probe can be found by itself.
  bool clear() const { return prominence >= kClear; }
};

/// Finds one signal in others by their generalised cross-correlation  IFFT(Y S* / (|Y|² + g |S|²)),  powers
/// smoothed over a sixth of an octave, g the ratio of their sums: close to the matched filter for a weak
/// signal in noise of any colour, sharp for a strong one, and bounded where either has next to nothing.
/// Source: C. Knapp, G. Carter, "The generalized correlation method for estimation of time delay", IEEE
/// Trans. ASSP 24, 1976.
class CoarseSearch {
 public:
  /// [control] For recordings of up to `frames`.
  CoarseSearch(std::span<const double> played, std::size_t frames, Hertz sample_rate);
  /// [control]
  CoarseDelay find(std::span<const double> captured);
  /// [control] What a path of that model makes of what was played, from the frequency `lowest` on.
  std::vector<double> behind(const PathModel& model, Hertz lowest);
  /// [control] A recording, from the frequency `lowest` on.
  std::vector<double> above(std::span<const double> captured, Hertz lowest);

 private:
  /// At delays from 0 on, those below 0 from the end backwards.
  std::vector<double> correlation(std::span<const double> captured);
  std::vector<double> from(Hertz lowest, Spectrum spectrum);
  /// Of the probe's energy, what a recording holds of it that comes so late.
  double share_within(std::int64_t delay) const;

  Hertz sample_rate_;
  std::int64_t frames_;
  Fourier fourier_;
  Spectrum played_;
  std::vector<double> played_power_;  ///< smoothed
  std::vector<double> energy_;        ///< of what was played, up to each frame
};

}  // namespace tactus
