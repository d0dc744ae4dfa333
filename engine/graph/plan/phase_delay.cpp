#include "engine/graph/plan/phase_delay.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus {

std::optional<double> PhaseDelay::phase_delay(double tuned) const noexcept {
  if (!(tuned > 0)) return std::nullopt;
  const double frequency = 1 / tuned;
  const auto response = other_->response(0, 0, on_circle(Hertz{frequency}, sample_rate_), values_);
  if (!response) return std::nullopt;
  return -std::arg(*response) / (2 * std::numbers::pi * frequency);
}

void PhaseDelay::process(const NodeBlock& block) noexcept {
  for (int frame = 0; frame < block.frames; ++frame) {
    bool changed = !known_ || block.in[1][frame] != tuned_;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const double now = block.in[i + 2][frame];
      changed |= now != values_[i];
      values_[i] = now;
    }
    if (changed) {
      tuned_ = block.in[1][frame];
      result_ = phase_delay(tuned_).value_or(0);
      known_ = true;
    }
    block.out[0][frame] = block.in[0][frame] + sign_ * result_;
  }
}

std::optional<double> PhaseDelay::at(const std::shared_ptr<const Node>& other, double tuned,
                                     const std::vector<double>& inputs, Hertz sample_rate) {
  PhaseDelay probe{other, static_cast<int>(inputs.size()), sample_rate, 1};
  probe.values_ = inputs;
  return probe.phase_delay(tuned);
}

std::optional<Interval> PhaseDelay::range(const std::shared_ptr<const Node>& other, Interval tuned,
                                          const std::vector<Interval>& inputs, Hertz sample_rate) {
  PhaseDelay probe{other, static_cast<int>(inputs.size()), sample_rate, 1};
  std::optional<Interval> found;
  constexpr int kSteps = 64;
  const std::size_t corners = std::size_t{1} << std::min<std::size_t>(inputs.size(), 8);
  for (std::size_t corner = 0; corner < corners; ++corner) {
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      const auto& range = inputs[i];
      const double end = (corner >> i & 1) != 0 ? range.high : range.low;
      probe.values_[i] = std::isfinite(end) ? end : 0;
    }
    for (int step = 0; step <= kSteps; ++step) {
      const double time = tuned.low * std::pow(tuned.high / tuned.low, static_cast<double>(step) / kSteps);
      const auto delay = probe.phase_delay(time);
      if (!delay) continue;
      if (!found) found = Interval::exactly(*delay);
      found = Interval{std::min(found->low, *delay), std::max(found->high, *delay)};
    }
  }
  return found;
}

}  // namespace tactus
