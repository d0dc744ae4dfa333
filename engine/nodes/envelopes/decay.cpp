#include <algorithm>

#include "engine/nodes/envelopes/decay_kernel.h"
#include "engine/nodes/envelopes/envelopes.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

class Decay final : public Node {
 public:
  explicit Decay(const NodeSetup& setup) : sample_rate_(setup.sample_rate.value) {}

  void process(const NodeBlock& block) noexcept override {
    if (block.frames == 1)
      step(block, 0, 1);
    else
      process_row(block);
  }
  void reset() noexcept override { state_ = {}; }

 private:
  static constexpr int kAtOnce = 8;

  // Not inlined: what many frames need to be set up would delay a single one.
  [[gnu::noinline]] void process_row(const NodeBlock& block) noexcept {
    const Signal trigger = block.in[0], time = block.in[1], length = block.in[3];
    const bool resting = time.constant() && length.constant() && !trigger.constant();
    for (int n = 0; n < block.frames;) {
      int count = block.frames - n;
      if (resting && tactus_rise_indifferent(&state_.rise, trigger.data + n, count) != 0)
        tactus_pulse_run(&state_.pulse, block.out[0] + n, count,
                         tactus_time_constant_keep(&state_.time, time[0], sample_rate_),
                         length[0] * sample_rate_);
      else
        step(block, n, count = std::min(kAtOnce, count));
      n += count;
    }
  }

  void step(const NodeBlock& block, int from, int count) noexcept {
    const Signal trigger = block.in[0], time = block.in[1], level = block.in[2], length = block.in[3];
    for (int n = from; n < from + count; ++n)
      block.out[0][n] = tactus_decay_step(&state_, trigger[n], time[n], level[n], length[n], sample_rate_);
  }

  double sample_rate_;
  tactus_decay state_{};
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
