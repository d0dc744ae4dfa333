#include "engine/dsp/strings/wave_line.h"

#include "engine/dsp/delays/taps.h"

namespace tactus {

WaveLine::WaveLine(LossFilter filter, FarEnd end, Hertz sample_rate, Pitches pitches)
    : WaveLine(filter,
               tactus_waveguide_between(pitches.lowest, pitches.highest, filter == LossFilter::OnePole,
                                        end == FarEnd::Fixed, sample_rate.value)) {}

WaveLine::WaveLine(LossFilter filter, const tactus_waveguide& guide)
    : DesignedLine(filter, guide.most + kMostFrames + StringDesign::kTaps), guide_(guide) {
  set(designed(parameters_));
}

StringDesign WaveLine::designed(const StringParameters& p) const {
  return StringDesign{tactus_waveguide_design(&guide_, p.pitch_hz, p.gain, p.loss)};
}

void WaveLine::tune(const StringParameters& parameters) noexcept {
  if (changed(parameters)) set(designed(parameters));
}

void WaveLine::read(double* out, int frames, int written, int position) noexcept {
  tap_sums(newest_tap(written), design_.taps, nullptr, out, frames);
  if (filter_ == LossFilter::OnePole) losses_.run(out, out, frames, position);
}

std::complex<double> WaveLine::response(const StringParameters& parameters,
                                        std::complex<double> delay) const {
  return designed(parameters).loop(delay);
}

}  // namespace tactus
