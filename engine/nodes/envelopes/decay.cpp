#include "engine/nodes/declare.h"
#include "engine/nodes/envelopes/pulse_kernel.h"
#include "engine/nodes/process.h"

namespace tactus {
namespace {

constexpr double kHigh = 0.5;  // as tactus_rise_step

class DecayNode final : public Node {
 public:
  explicit DecayNode(const NodeSetup& setup) : sample_rate_(setup.sample_rate.value) {}

  void process(const NodeBlock& block) noexcept override {
    if (block.frames == 1) return step(block, 0, 1);
    process_frames(block);
  }
  void reset() noexcept override { state_ = {}; }
  void copy(const Node& other) noexcept override { assign(*this, other); }

 private:
  // Not inlined: the setup for many frames would delay a single one.
  [[gnu::noinline]] void process_frames(const NodeBlock& block) noexcept {
    const Signal trigger = block.in[0], time = block.in[1], length = block.in[3];
    run_with_skips(
        block, time.constant() && length.constant() && !trigger.constant(),
        [&](int from, int count) { return skip(block, from, count); },
        [&](int from, int count) { step(block, from, count); });
  }

  /// Frames in which nothing rises.
  bool skip(const NodeBlock& block, int from, int count) noexcept {
    if (state_.rise.high != 0 || any_at_least(block.in[0].data + from, count, kHigh)) return false;
    tactus_pulse_run(&state_.pulse, block.out[0] + from, count,
                     tactus_time_constant_keep(&state_.time, *block.in[1].data, sample_rate_),
                     *block.in[3].data * sample_rate_);
    return true;
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

NodeType decay_type() {
  return {
      .name = "decay",
      .summary = "A pulse at each trigger: jumps to its level and decays exponentially.",
      .equation = "out(t) = level exp(-t / time), t since the last trigger; if length > 0, 0 for t >= length",
      .source = "elementary",
      .example = "pulse = { type = \"decay\", trigger = \"hit\", time = \"12 ms\" }",
      .inputs = {{"trigger", "", "starts the pulse in the frame of the trigger"},
                 {"time", "s", "time constant, in which the pulse falls to 37 %", {}, 0},
                 {"level", "any", "height of the pulse, read at the trigger", 1},
                 {"length", "s", "duration after which the pulse is cut to 0; 0: never", 0, 0}},
      .outputs = {{"out", "=level", "the pulse"}},
      .silencers = {{"trigger"}, {"level"}},
      .make = make_node<DecayNode>,
      .range = from_zero_to("level"),
  };
}

}  // namespace tactus
