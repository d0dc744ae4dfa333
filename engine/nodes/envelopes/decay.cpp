#include <algorithm>

#include "engine/dsp/envelopes/pulse.h"
#include "engine/dsp/envelopes/rise.h"
#include "engine/dsp/envelopes/time_constant.h"
#include "engine/nodes/envelopes/envelopes.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

class Decay final : public Node {
 public:
  explicit Decay(const NodeSetup& setup) : sample_rate_(setup.sample_rate.value), time_(setup.sample_rate) {}

  void process(const NodeBlock& block) noexcept override {
    if (block.frames == 1)
      step(block, 0, 1);
    else
      process_row(block);
  }
  void reset() noexcept override {
    rise_ = {};
    pulse_ = {};
  }

 private:
  static constexpr int kAtOnce = 8;

  // Not inlined: what many frames need to be set up would delay a single one.
  [[gnu::noinline]] void process_row(const NodeBlock& block) noexcept {
    const Signal trigger = block.in[0], time = block.in[1], length = block.in[3];
    const bool resting = time.constant() && length.constant() && !trigger.constant();
    for (int n = 0; n < block.frames;) {
      int count = block.frames - n;
      if (resting && rise_.indifferent(trigger.data + n, count))
        pulse_.run(block.out[0] + n, count, time_.keep(time[0]), length[0] * sample_rate_);
      else
        step(block, n, count = std::min(kAtOnce, count));
      n += count;
    }
  }

  void step(const NodeBlock& block, int from, int count) noexcept {
    const Signal trigger = block.in[0], time = block.in[1], level = block.in[2], length = block.in[3];
    for (int n = from; n < from + count; ++n) {
      if (rise_.step(trigger[n])) pulse_.start(level[n]);
      block.out[0][n] = pulse_.step(time_.keep(time[n]), length[n] * sample_rate_);
    }
  }

  double sample_rate_;
  TimeConstant time_;
  Rise rise_;
  Pulse pulse_;
};

}  // namespace

const NodeType& decay_type() {
  static const NodeType type = {
      .name = "decay",
      .group = "envelopes",
      .summary = "A pulse at each trigger: jumps to its level and decays exponentially.",
      .equation = "out(t) = level exp(-t / time), t since the last trigger; 0 for t >= length > 0",
      .source = "elementary",
      .example = "pulse = { type = \"decay\", trigger = \"hit\", time = \"12 ms\" }",
      .inputs =
          {{.name = "trigger", .unit = "", .doc = "starts the pulse in its own frame"},
           {.name = "time", .unit = "s", .doc = "time constant: the pulse falls to 37 % in it", .low = 0},
           {.name = "level", .unit = "any", .doc = "height, taken over at the trigger", .fallback = 1},
           {.name = "length",
            .unit = "s",
            .doc = "the pulse ends after this time; 0: never",
            .fallback = 0,
            .low = 0}},
      .outputs = {{.name = "out", .unit = "=level", .doc = "the pulse"}},
      .make = make_node<Decay>,
      .range = [](int,
                  const NodeSetup& setup) { return setup.input("level").range.joined(Interval::exactly(0)); },
  };
  return type;
}

}  // namespace tactus
