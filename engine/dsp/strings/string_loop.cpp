#include "engine/dsp/strings/string_loop.h"

#include <algorithm>

#include "engine/dsp/delays/taps.h"

namespace tactus {

int StringLoop::longest_delay(Hertz sample_rate, double lowest_pitch) {
  return static_cast<int>(sample_rate.value / std::max(kLowestPitch, lowest_pitch)) + StringDesign::kTaps;
}

StringLoop::StringLoop(LossFilter filter, Hertz sample_rate, double lowest_pitch)
    : DesignedLine(filter, longest_delay(sample_rate, lowest_pitch)), sample_rate_(sample_rate) {
  set({parameters_, filter, sample_rate});
}

void StringLoop::tune(const StringParameters& parameters, int /*lane*/) noexcept {
  if (changed(parameters)) set({parameters, filter_, sample_rate_});
}

/// As long as the newest tap lies before it, and ending with a group where that is possible: a cut group
/// costs nearly as much as a whole one.
int StringLoop::sub_block(int frames, int position) const noexcept {
  const int most = std::min(kMostFrames, design_.newest);
  if (frames <= most) return frames;
  const int whole = most - (position + most) % kGroup;
  return whole > 0 ? whole : most;
}

double StringLoop::run_single(double x, int position) noexcept {
  if (filter_ == LossFilter::OneZero)
    return tactus_string_step(&design_, 0, line_.line(), nullptr, x, position);
  const double around = tactus_tap_sum(newest_tap(), design_.taps, StringDesign::kTaps, 0);
  const double y = x + losses_.run_single(around, position);
  tactus_line_write(line_.line(), y);
  return y;
}

void StringLoop::run(const double* x, double* y, int frames, int position) noexcept {
  while (frames > 0) {
    const int count = sub_block(frames, position);
    const double* newest = newest_tap();
    if (filter_ == LossFilter::OneZero) {
      tap_sums<StringDesign::kTaps>(newest, design_.taps, x, y, count);
    } else {
      std::array<double, kMostFrames> around;
      tap_sums<StringDesign::kTaps>(newest, design_.taps, nullptr, around.data(), count);
      losses_.run(around.data(), around.data(), count, position);
      for (int n = 0; n < count; ++n) y[n] = x[n] + around[static_cast<std::size_t>(n)];
    }
    line_.write(y, count);
    x += count, y += count, frames -= count;
    position = (position + count) % kGroup;
  }
}

VectorStringLoop::VectorStringLoop(LossFilter filter, Hertz sample_rate, double lowest_pitch)
    : filter_(filter),
      sample_rate_(sample_rate),
      line_(StringLoop::longest_delay(sample_rate, lowest_pitch) * Lanes::kCount,
            (kMostFrames + StringDesign::kTaps) * Lanes::kCount) {
  const StringDesign design{{}, filter, sample_rate};
  for (int lane = 0; lane < Lanes::kCount; ++lane) take(lane, design);
}

void VectorStringLoop::tune(const StringParameters& parameters, int lane) noexcept {
  auto& before = parameters_[static_cast<std::size_t>(lane)];
  if (parameters == before) return;
  before = parameters;
  take(lane, StringDesign{parameters, filter_, sample_rate_});
}

void VectorStringLoop::take(int lane, const StringDesign& design) noexcept {
  const auto l = static_cast<std::size_t>(lane);
  newest_[l] = design.newest;
  pole_[l] = design.pole;
  for (std::size_t k = 0; k < kTaps; ++k) weights_[k][l] = design.taps[k];
  shortest_ = *std::min_element(newest_.begin(), newest_.end());
}

void VectorStringLoop::reset() noexcept {
  line_.reset();
  loss_.fill(0.0);
}

}  // namespace tactus
