#include "engine/dsp/strings/vector_string_loop.h"

#include <algorithm>

namespace tactus {

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
