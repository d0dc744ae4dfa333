#pragma once

// Thread: [realtime]; constructors [control].

#include "engine/dsp/strings/string_loop.h"

namespace tactus {

/// Termination of the far end of a line. Waves of force come back from a fixed end as they went, from a free
/// end upside down.
enum class FarEnd { Fixed, Free };

/// A string or a rod seen from one end: waves of force go in, travel to the far end and come back.
///
///   out[n] = +-(h * in)[n - (N - 1)]      + fixed, - free
///
/// h is the gain and the loss of StringDesign and N its delay, read between samples. kPortFrames
/// are left to what the line hangs on, so that both together, N frames around, are in tune: with a rigid near
/// end the line sounds at the pitch (fixed), or at odd multiples of half the pitch (free). It reflects at
/// most `gain`: |out / in| = gain |H_LP| |interpolator| <= 1 at every frequency, as long as pitch and loss
/// rest. At least `least_delay` frames lie between in and out for all parameters. Source: J. O. Smith,
/// Physical Audio Signal Processing, W3K, 2010.
class WaveLine : public DesignedLine {
 public:
  /// The range of its pitch; others are clamped to these and to [10 Hz, 0.2 fs].
  struct Pitches {
    double lowest, highest;
  };
  static constexpr double kMostGain = 1;
  /// What a network's port takes to answer.
  static constexpr double kPortFrames = 1.0;
  using DesignedLine::kMostFrames;

  /// [control] Allocates for the lowest pitch.
  WaveLine(LossFilter filter, FarEnd end, Hertz sample_rate, Pitches pitches);

  /// [realtime] At the start of a group only (see Recurrence). Does nothing when nothing changed.
  void tune(const StringParameters& parameters) noexcept;
  /// [realtime] What goes in.
  void write(const double* in, int frames) noexcept { line_.write(in, frames); }
  /// [realtime] What comes back, beginning `written` frames before the last that was written. `position` is
  /// the group_position of the first frame. Not before the line's delay: frames - written <= least_delay().
  void read(double* out, int frames, int written, int position) noexcept;
  int least_delay() const noexcept { return least_; }
  int most_delay() const noexcept { return most_; }
  /// [any] out / in at any z^-1.
  std::complex<double> response(const StringParameters& parameters, std::complex<double> delay) const;

 private:
  StringDesign designed(const StringParameters& parameters) const;

  double sign_;
  Hertz sample_rate_;
  Pitches pitches_;
  int least_, most_;
};

}  // namespace tactus
