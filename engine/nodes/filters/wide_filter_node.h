#pragma once

// Thread: [realtime] what engine/graph/node.h says so; constructors [control].

#include <array>

#include "engine/dsp/filters/wide_filter.h"
#include "engine/nodes/group_steps.h"
#include "engine/nodes/wide_signal.h"

namespace tactus {

/// Eight FilterNodes side by side.
template <int Order, std::size_t ParameterCount>
class WideFilterNode final : public Node {
 public:
  using Parameters = std::array<double, ParameterCount>;
  using Design = FilterCoefficients<Order> (*)(const Parameters&, Hertz sample_rate);

  WideFilterNode(Design design, Hertz sample_rate, bool has_rest)
      : design_(design), sample_rate_(sample_rate), has_rest_(has_rest) {}

  void process(const NodeBlock& block) noexcept override {
    const WideSignal x{block.in[0]};
    std::array<double, static_cast<std::size_t>(kMaxSubBlock * kVectorWidth)> unread;
    double* const y = block.out[0] != nullptr ? block.out[0] : unread.data();
    steps_.go(
        block, rest(block, 1, ParameterCount), [&](int frame) { update(block, frame); },
        [&](int from, int to, int) { filter_.run(x.from(from), y + from * kVectorWidth, to - from); });
    if (!has_rest_ || block.out[1] == nullptr) return;
    for (int n = 0; n < block.frames; ++n)
      (x[n] - Lanes::load(y + n * kVectorWidth)).store(block.out[1] + n * kVectorWidth);
  }

  void reset() noexcept override {
    filter_.reset();
    steps_.reset();
    designed_ = false;
  }

 private:
  void update(const NodeBlock& block, int frame) noexcept {
    for (int lane = 0; lane < kVectorWidth; ++lane) {
      Parameters now;
      for (std::size_t i = 0; i < ParameterCount; ++i) now[i] = WideSignal{block.in[i + 1]}.lane(lane, frame);
      auto& before = parameters_[static_cast<std::size_t>(lane)];
      if (designed_ && now == before) continue;
      before = now;
      filter_.design(lane, design_(now, sample_rate_));
    }
    designed_ = true;
  }

  Design design_;
  Hertz sample_rate_;
  bool has_rest_;
  bool designed_ = false;
  std::array<Parameters, kVectorWidth> parameters_{};
  GroupSteps steps_;
  WideFilter<Order> filter_;
};

}  // namespace tactus
