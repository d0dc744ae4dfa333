#pragma once

// Thread: [realtime] what engine/graph/node.h says so; constructors [control].

#include <algorithm>

#include "engine/dsp/strings/wide_string_loop.h"
#include "engine/nodes/group_steps.h"
#include "engine/nodes/wide_signal.h"

namespace tactus {

/// Eight StringNodes side by side.
class WideStringNode final : public Node {
 public:
  WideStringNode(LossFilter filter, Hertz sample_rate, double lowest_pitch)
      : lowest_pitch_(lowest_pitch), strings_(filter, sample_rate, lowest_pitch) {}

  void process(const NodeBlock& block) noexcept override {
    const WideSignal x{block.in[0]}, pitch{block.in[1]}, gain{block.in[2]}, loss{block.in[3]};
    steps_.go(
        block, rest(block, 1, 3),
        [&](int n) {
          for (int l = 0; l < kVectorWidth; ++l)
            strings_.tune(l, {.pitch_hz = std::max(lowest_pitch_, pitch.lane(l, n)),
                              .gain = gain.lane(l, n),
                              .loss = loss.lane(l, n)});
        },
        [&](int from, int to, int) {
          strings_.run(x.from(from), block.out[0] + from * kVectorWidth, to - from);
        });
  }

  void adopt(Node& before) noexcept override {
    if (auto* other = dynamic_cast<WideStringNode*>(&before)) strings_.adopt(other->strings_);
  }

  void reset() noexcept override {
    strings_.reset();
    steps_.reset();
  }

 private:
  double lowest_pitch_;
  WideStringLoop strings_;
  GroupSteps steps_;
};

}  // namespace tactus
