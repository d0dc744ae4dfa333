#pragma once

// Thread: [realtime]; constructors [control].

#include "engine/dsp/strings/string_loop.h"
#include "engine/dsp/strings/waveguide_kernel.h"

namespace tactus {

/// Termination of the far end of a line. Waves of force come back from a fixed end as they went, from a free
/// end upside down.
enum class FarEnd { Fixed, Free };

/// `tactus_waveguide_step` for many frames.
class WaveLine : public DesignedLine {
 public:
  /// The range of its pitch.
  struct Pitches {
    double lowest, highest;
  };
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
  int least_delay() const noexcept { return guide_.least; }
  int most_delay() const noexcept { return guide_.most; }
  /// [any] out / in at any z^-1.
  std::complex<double> response(const StringParameters& parameters, std::complex<double> delay) const;

 private:
  WaveLine(LossFilter filter, const tactus_waveguide& guide);
  StringDesign designed(const StringParameters& parameters) const;

  tactus_waveguide guide_;
};

}  // namespace tactus
