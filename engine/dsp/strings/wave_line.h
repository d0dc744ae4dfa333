#pragma once

// Thread: [realtime]; constructors [control].

#include "engine/dsp/strings/string_kernel.h"
#include "engine/dsp/strings/string_loop.h"

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
  WaveLine(LossFilter filter, FarEnd end, Hertz sample_rate, Pitches pitches)
      : WaveLine(filter,
                 tactus_waveguide_between(pitches.lowest, pitches.highest, filter == LossFilter::OnePole,
                                          end == FarEnd::Fixed, sample_rate.value)) {}

  /// [realtime] At the start of a group only (see Recurrence). Does nothing when nothing changed.
  void tune(const StringParameters& parameters) noexcept {
    if (changed(parameters)) set(designed(parameters));
  }
  /// [realtime] What goes in.
  void write(const double* in, int frames) noexcept { line_.write(in, frames); }
  /// [realtime] What comes back, beginning `written` frames before the last that was written. `position` is
  /// the group_position of the first frame. Not before the line's delay: frames - written <= least_delay().
  void read(double* out, int frames, int written, int position) noexcept {
    tap_sums(newest_tap(written), design_.taps, nullptr, out, frames);
    if (filter_ == LossFilter::OnePole) losses_.run(out, out, frames, position);
  }
  int least_delay() const noexcept { return guide_.least; }
  int most_delay() const noexcept { return guide_.most; }
  /// [any] out / in at any z^-1.
  std::complex<double> response(const StringParameters& parameters, std::complex<double> delay) const {
    return designed(parameters).loop(delay);
  }

 private:
  WaveLine(LossFilter filter, const tactus_waveguide& guide)
      : DesignedLine(filter, guide.most + kMostFrames + StringDesign::kTaps), guide_(guide) {
    set(designed(parameters_));
  }
  StringDesign designed(const StringParameters& p) const {
    return StringDesign{tactus_waveguide_design(&guide_, p.pitch_hz, p.gain, p.loss)};
  }

  tactus_waveguide guide_;
};

}  // namespace tactus
