#include "engine/nodes/declare.h"
#include "engine/nodes/logic/state_kernel.h"

namespace tactus {
namespace {

class StateNode final : public Node {
  enum Input { kIn, kTrigger, kInitial };

 public:
  explicit StateNode(const NodeSetup&) {}

  void process(const NodeBlock& block) noexcept override {
    for (int n = 0; n < block.frames; ++n) {
      block.out[0][n] = tactus_state_value(&state_, block.in[kInitial][n]);
      tactus_state_take(&state_, block.in[kIn][n], block.in[kTrigger][n]);
    }
  }
  /// Loops run frame by frame: the shortest delay is one frame.
  void emit(const NodeBlock& block) noexcept override {
    for (int n = 0; n < block.frames; ++n)
      block.out[0][n] = tactus_state_value(&state_, block.in[kInitial][n]);
  }
  void absorb(const NodeBlock& block) noexcept override {
    for (int n = 0; n < block.frames; ++n)
      tactus_state_take(&state_, block.in[kIn][n], block.in[kTrigger][n]);
  }
  DelayRange delay(int input, int) const override {
    return input == kInitial ? DelayRange{} : DelayRange{1, 1};
  }
  void reset() noexcept override { state_ = {}; }
  void copy(const Node& other) noexcept override { assign(*this, other); }

 private:
  tactus_state state_{};
};

class IntervalNode final : public Node {
  enum Input { kTrigger, kInitial };

 public:
  explicit IntervalNode(const NodeSetup& setup) : rate_(setup.sample_rate.value) {}

  void process(const NodeBlock& block) noexcept override {
    for (int n = 0; n < block.frames; ++n) {
      block.out[0][n] = tactus_interval_value(&state_, block.in[kInitial][n], rate_);
      tactus_interval_pass(&state_, block.in[kTrigger][n]);
    }
  }
  void emit(const NodeBlock& block) noexcept override {
    for (int n = 0; n < block.frames; ++n)
      block.out[0][n] = tactus_interval_value(&state_, block.in[kInitial][n], rate_);
  }
  void absorb(const NodeBlock& block) noexcept override {
    for (int n = 0; n < block.frames; ++n) tactus_interval_pass(&state_, block.in[kTrigger][n]);
  }
  DelayRange delay(int input, int) const override {
    return input == kInitial ? DelayRange{} : DelayRange{1, 1};
  }
  void reset() noexcept override { state_ = {}; }
  void copy(const Node& other) noexcept override { assign(*this, other); }

 private:
  double rate_;
  tactus_interval state_{};
};

Interval state_range(int, const NodeSetup& setup) {
  return setup.input("in").range.joined(setup.input("initial").range);
}

}  // namespace

NodeType state_type() {
  return {
      .name = "state",
      .summary = "A value that changes at triggers and may depend on itself: `in` can read the value before.",
      .equation = "out[n + 1] = in[n] in the frame n of a trigger, else out[n]; initial before the first one",
      .source = "a clocked register",
      .example =
          "strength = { type = \"state\", in = \"0.9 * strength + 0.1 * level\", trigger = \"hit\", "
          "initial = 0.5 }",
      .inputs = {late({"in", "any", "next value"}),
                 late(sampling({"trigger", "", "trigger that takes over `in`"})),
                 {"initial", "=in", "value before the first trigger", 0}},
      .outputs = {{"out", "=in", "the value"}},
      .make = make_node<StateNode>,
      .small_signal_gain = 1,
      .dead_band = true,
      .range = state_range,
  };
}

NodeType interval_type() {
  return {
      .name = "interval",
      .summary = "Time since the last trigger: in the frame of a trigger, the interval that it ends.",
      .equation =
          "out[n] = (n - m) / rate, m < n the frame of the last trigger before n; before the first one "
          "initial + n / rate",
      .source = "elementary",
      .example = "flight = { type = \"interval\", trigger = \"hit\" }",
      .inputs = {late({"trigger", "", "trigger that starts an interval"}),
                 {"initial", "s", "time since a trigger before the start", 0, 0, 1e9}},
      .outputs = {bounded(0, kUnlimited, {"out", "s", "time since the last trigger"})},
      .make = make_node<IntervalNode>,
  };
}

}  // namespace tactus
