#include "engine/dsp/strings/wave_line.h"

#include <algorithm>
#include <cmath>

#include "engine/dsp/delays/taps.h"

namespace tactus {
namespace {

WaveLine::Pitches possible(WaveLine::Pitches asked, Hertz sample_rate) {
  const double top = 0.2 * sample_rate.value;
  const double lowest = std::clamp(asked.lowest, StringLoop::kLowestPitch, top);
  return {lowest, std::clamp(asked.highest, lowest, top)};
}

}  // namespace

WaveLine::WaveLine(LossFilter filter, FarEnd end, Hertz sample_rate, Pitches pitches)
    : filter_(filter),
      sign_(end == FarEnd::Fixed ? 1 : -1),
      sample_rate_(sample_rate),
      pitches_(possible(pitches, sample_rate)),
      // A loss takes time as well: the darkest leaves the shortest delay.
      least_(designed({pitches_.highest, 1, 1}).newest),
      most_(designed({pitches_.lowest, 1, 0}).newest),
      aim_(aim_at(parameters_)),
      line_(most_ + kLongest + StringDesign::kTaps, kLongest + StringDesign::kTaps) {
  losses_.design({aim_.pole});
}

StringDesign WaveLine::designed(StringParameters parameters) const {
  const double pitch = parameters.pitch_hz;
  parameters.pitch_hz = pitch > pitches_.lowest ? std::min(pitch, pitches_.highest) : pitches_.lowest;
  return {parameters, filter_, sample_rate_, kMostGain, kPortFrames};
}

WaveLine::Aim WaveLine::aim_at(const StringParameters& parameters) const {
  const auto design = designed(parameters);
  Aim aim{std::clamp(design.newest, least_, most_), design.taps, design.pole};
  for (auto& tap : aim.taps) tap *= sign_;
  return aim;
}

void WaveLine::tune(const StringParameters& parameters) noexcept {
  if (parameters == parameters_) return;
  parameters_ = parameters;
  aim_ = aim_at(parameters);
  losses_.design({aim_.pole});
}

void WaveLine::read(double* out, int frames, int written, int position) noexcept {
  constexpr int kOlder = StringDesign::kTaps - 1;
  const double* newest = line_.behind(aim_.newest + kOlder + written) + kOlder;
  tap_sums(newest, aim_.taps, nullptr, out, frames);
  if (filter_ == LossFilter::OnePole) losses_.run(out, out, frames, position);
}

void WaveLine::reset() noexcept {
  line_.reset();
  losses_.reset();
}

void WaveLine::adopt(WaveLine& other) noexcept {
  line_.adopt(other.line_);
  if (filter_ == other.filter_) losses_.adopt(other.losses_);
}

std::complex<double> WaveLine::response(const StringParameters& parameters,
                                        std::complex<double> delay) const {
  const auto aim = aim_at(parameters);
  std::complex<double> sum = 0;
  for (std::size_t k = aim.taps.size(); k-- > 0;) sum = sum * delay + aim.taps[k];
  return sum * std::pow(delay, aim.newest) / (1.0 - aim.pole * delay);
}

}  // namespace tactus
