#include "engine/dsp/strings/wave_line.h"

#include <algorithm>
#include <cmath>

#include "engine/dsp/delays/taps.h"

namespace tactus {
namespace {

WaveLine::Pitches possible(WaveLine::Pitches requested, Hertz sample_rate) {
  const double top = 0.2 * sample_rate.value;
  const double lowest = std::clamp(requested.lowest, StringLoop::kLowestPitch, top);
  return {lowest, std::clamp(requested.highest, lowest, top)};
}

/// The pitch is clamped to `pitches`.
StringDesign design_within(const WaveLine::Pitches& pitches, StringParameters parameters, LossFilter filter,
                           Hertz sample_rate) {
  const double pitch = parameters.pitch_hz;
  parameters.pitch_hz = pitch > pitches.lowest ? std::min(pitch, pitches.highest) : pitches.lowest;
  return {parameters, filter, sample_rate, WaveLine::kMostGain, WaveLine::kPortFrames};
}

/// A loss takes time as well: the darkest leaves the shortest delay.
int least_delay_of(const WaveLine::Pitches& pitches, LossFilter filter, Hertz sample_rate) {
  return design_within(pitches, {pitches.highest, 1, 1}, filter, sample_rate).newest;
}
int most_delay_of(const WaveLine::Pitches& pitches, LossFilter filter, Hertz sample_rate) {
  return design_within(pitches, {pitches.lowest, 1, 0}, filter, sample_rate).newest;
}

}  // namespace

WaveLine::WaveLine(LossFilter filter, FarEnd end, Hertz sample_rate, Pitches pitches)
    : DesignedLine(filter, most_delay_of(possible(pitches, sample_rate), filter, sample_rate) + kMostFrames +
                               StringDesign::kTaps),
      sign_(end == FarEnd::Fixed ? 1 : -1),
      sample_rate_(sample_rate),
      pitches_(possible(pitches, sample_rate)),
      least_(least_delay_of(pitches_, filter, sample_rate)),
      most_(most_delay_of(pitches_, filter, sample_rate)) {
  set(designed(parameters_));
}

StringDesign WaveLine::designed(const StringParameters& parameters) const {
  auto design = design_within(pitches_, parameters, filter_, sample_rate_);
  design.newest = std::clamp(design.newest, least_, most_);
  for (auto& tap : design.taps) tap *= sign_;
  return design;
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
