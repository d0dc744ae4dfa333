#include "engine/nodes/declare.h"
#include "engine/nodes/logic/threshold_skip.h"
#include "engine/nodes/process.h"

namespace tactus {
namespace {

constexpr double kLongestHold_s = 3600;

class ThresholdNode final : public Node {
  enum Input { kIn, kLevel, kHysteresis, kHold };

 public:
  explicit ThresholdNode(const NodeSetup& setup) : sample_rate_(setup.sample_rate.value) {}

  void process(const NodeBlock& block) noexcept override {
    if (block.frames == 1) return step(block, 0, 1);
    process_frames(block);
  }
  void reset() noexcept override { state_ = {}; }
  void copy(const Node& other) noexcept override { assign(*this, other); }

 private:
  // Not inlined: the setup for many frames would delay a single one.
  [[gnu::noinline]] void process_frames(const NodeBlock& block) noexcept {
    run_with_skips(
        block, all_constant(block, kLevel, 2) && !block.in[kIn].constant(),
        [&](int from, int count) { return skip(block, from, count); },
        [&](int from, int count) { step(block, from, count); });
  }

  static double hysteresis(const NodeBlock& block, int n) { return std::max(0.0, block.in[kHysteresis][n]); }
  double hold_frames(const NodeBlock& block, int n) const {
    return std::clamp(block.in[kHold][n], 0.0, kLongestHold_s) * sample_rate_;
  }

  /// Frames that change nothing.
  bool skip(const NodeBlock& block, int from, int count) noexcept {
    if (!changes_nothing(state_, block.in[kIn].data + from, count, *block.in[kLevel].data,
                         hysteresis(block, 0)))
      return false;
    tactus_threshold_pass(&state_, count);
    if (block.out[0] != nullptr) fill_samples(block.out[0] + from, count, 0);
    if (block.out[1] != nullptr) fill_samples(block.out[1] + from, count, state_.high);
    return true;
  }
  void step(const NodeBlock& block, int from, int count) noexcept {
    const Signal in = block.in[kIn], level = block.in[kLevel];
    for (int n = from; n < from + count; ++n) {
      const int fired =
          tactus_threshold_step(&state_, in[n], level[n], hysteresis(block, n), hold_frames(block, n));
      if (block.out[0] != nullptr) block.out[0][n] = fired;
      if (block.out[1] != nullptr) block.out[1][n] = state_.high;
    }
  }

  double sample_rate_;
  tactus_threshold state_{};
};

}  // namespace

NodeType threshold_type() {
  return {
      .name = "threshold",
      .summary =
          "Triggers when a signal reaches a level, and again only after it has fallen below the level by the "
          "hysteresis.",
      .equation =
          "high from in >= level until in < level - hysteresis;\n"
          "out = 1 in the first frame with in >= level since it was low, `hold` or more after the last",
      .source = "Schmitt, J. Sci. Instrum. 15, 1938",
      .example =
          "touched = { type = \"threshold\", in = \"pressure\", level = \"0.5 N\", hysteresis = \"0.1 N\" }",
      .inputs = {{"in", "any", "signal"},
                 {"level", "=in", "level of the threshold"},
                 {"hysteresis", "=in", "distance below `level` at which it is released", 0, 0},
                 event_hold({"hold", "s",
                             "hold-off: time after a trigger in which further triggers are ignored", 0, 0,
                             kLongestHold_s})},
      .outputs = {{.name = "out",
                   .unit = "",
                   .doc = "trigger when the signal rises to the level",
                   .kind = OutputKind::Trigger,
                   .range = {0, 1}},
                  bounded(0, 1, {"gate", "", "1 while the signal is high"})},
      .make = make_node<ThresholdNode>,
      .skips_unused_outputs = true,
  };
}

}  // namespace tactus
