#pragma once
// Thread: [control]

#include <array>
#include <optional>
#include <vector>

#include "latency/estimation/analysis.h"
#include "latency/estimation/fourier.h"
#include "latency/path/path_model.h"
#include "latency/probe/probe.h"

namespace tactus {

/// What the mean of all probes says about the path, besides its delay. The window begins at the delay `at`,
/// and the fit's delay counts from there.
class Response {
 public:
  Response(const CapturedWindow& window, const PathModel& model, Hertz sample_rate, Fourier& fourier)
      : window_(window), model_(model), sample_rate_(sample_rate), fourier_(fourier) {}

  /// [control] Twelve points an octave, where something was played.
  std::vector<ResponsePoint> spectrum() const;
  /// [control] Octaves around 1 kHz; `at` is added to each delay.
  std::vector<BandDelay> group_delay(double at) const;
  /// [control] From 5 ms before the delay to 25 ms after it.
  std::vector<double> impulse(int& first) const;
  /// [control] The share of the power that the model leaves unexplained which stands within 8 frames of its
  /// three highest places: near 1 for echoes, small for resonances; and how strong the highest is beside the
  /// path, and how far from it.
  struct Echo {
    double share = 0.0, level_db = 0.0;
    int frames = 0;
  };
  Echo echo() const;
  /// [control] H2 … H5 in dB below the fundamental, for fundamentals around 1 kHz: the responses that stand
  /// before the linear one in what was captured of an exponential probe. Nothing where noise is
  /// stronger, or below -90 dB. `differences`: of the probes, each second one subtracted: what is left is
  /// noise; empty: not known.
  std::array<std::optional<double>, 4> harmonics(const ExponentialSweep& probe,
                                                 const Spectrum& differences) const;

 private:
  double hertz(std::size_t bin) const {
    return static_cast<double>(bin) * sample_rate_.value / static_cast<double>(window_.size);
  }
  std::vector<double> deconvolved(const Spectrum& captured) const;

  const CapturedWindow& window_;
  const PathModel& model_;
  Hertz sample_rate_;
  Fourier& fourier_;
};

}  // namespace tactus
