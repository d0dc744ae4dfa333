#include "engine/nodes/decay.h"

#include "engine/dsp/pulse.h"
#include "engine/dsp/rise.h"
#include "engine/dsp/time_constant.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

class Decay final : public Node {
 public:
  explicit Decay(const NodeSetup& setup) : sample_rate_(setup.sample_rate.value), time_(setup.sample_rate) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal trigger = block.in[0], time = block.in[1], level = block.in[2], length = block.in[3];
    double keep = time_.keep(time[0]);
    Rise rise = rise_;
    Pulse pulse = pulse_;
    for (int i = 0; i < block.frames; ++i) {
      if (!time.constant()) keep = time_.keep(time[i]);
      if (rise.step(trigger[i])) pulse.start(level[i]);
      block.out[0][i] = pulse.step(keep, length[i] * sample_rate_);
    }
    rise_ = rise;
    pulse_ = pulse;
  }
  void reset() noexcept override {
    rise_ = {};
    pulse_ = {};
  }

 private:
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
      .inputs = {{.name = "trigger", .unit = "", .doc = "starts the pulse in its own frame", .fallback = {}},
                 {.name = "time",
                  .unit = "s",
                  .doc = "time constant: the pulse falls to 37 % in it",
                  .fallback = {},
                  .low = 0},
                 {.name = "level", .unit = "any", .doc = "height, taken over at the trigger", .fallback = 1},
                 {.name = "length",
                  .unit = "s",
                  .doc = "the pulse ends after this time; 0: never",
                  .fallback = 0,
                  .low = 0}},
      .outputs = {{.name = "out", .unit = "=level", .doc = "the pulse", .range = {}}},
      .settings = {},
      .make = make_node<Decay>,
      .range = [](int,
                  const NodeSetup& setup) { return setup.input("level").range.joined(Interval::exactly(0)); },
  };
  return type;
}

}  // namespace tactus
