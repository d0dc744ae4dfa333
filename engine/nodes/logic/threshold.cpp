#include <algorithm>

#include "engine/nodes/logic/logic.h"
#include "engine/nodes/logic/threshold_kernel.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

constexpr double kLongestHold = 3600;  // seconds

enum Input { kIn, kLevel, kHysteresis, kHold };

class Threshold final : public Node {
 public:
  explicit Threshold(const NodeSetup& setup) : sample_rate_(setup.sample_rate.value) {}

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
    const bool resting =
        block.in[kLevel].constant() && block.in[kHysteresis].constant() && !block.in[kIn].constant();
    for (int n = 0; n < block.frames;) {
      int count = block.frames - n;
      if (!resting || !skip(block, n, count)) {
        count = std::min(kAtOnce, count);
        step(block, n, count);
      }
      n += count;
    }
  }

  static double hysteresis(const NodeBlock& block, int n) { return std::max(0.0, block.in[kHysteresis][n]); }
  double hold_frames(const NodeBlock& block, int n) const {
    return std::clamp(block.in[kHold][n], 0.0, kLongestHold) * sample_rate_;
  }

  /// Most of the time nothing happens, which takes one look at several frames to see.
  bool skip(const NodeBlock& block, int from, int count) noexcept {
    const double* in = block.in[kIn].data + from;
    if (tactus_threshold_indifferent(&state_, in, count, block.in[kLevel][0], hysteresis(block, 0)) == 0)
      return false;
    tactus_threshold_pass(&state_, count);
    fill(block, from, count);
    return true;
  }
  void fill(const NodeBlock& block, int from, int count) const noexcept {
    if (block.out[0] != nullptr) std::fill_n(block.out[0] + from, count, 0.0);
    if (block.out[1] != nullptr) std::fill_n(block.out[1] + from, count, static_cast<double>(state_.high));
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

const NodeType& threshold_type() {
  static const NodeType type = {
      .name = "threshold",
      .group = "logic",
      .summary =
          "Triggers when a signal reaches a level, and again only after it fell below it by the hysteresis.",
      .equation =
          "high from in >= level until in < level - hysteresis;\n"
          "out = 1 in the first frame with in >= level since it was low, `hold` or more after the last",
      .source = "Schmitt, J. Sci. Instrum. 15, 1938",
      .example =
          "touched = { type = \"threshold\", in = \"pressure\", level = \"0.5 N\", hysteresis = \"0.1 N\" }",
      .inputs = {{.name = "in", .unit = "any", .doc = "signal"},
                 {.name = "level", .unit = "=in", .doc = "level to reach"},
                 {.name = "hysteresis",
                  .unit = "=in",
                  .doc = "how far below `level` it lets go",
                  .fallback = 0,
                  .low = 0},
                 {.name = "hold",
                  .unit = "s",
                  .doc = "time from a trigger in which no other comes",
                  .fallback = 0,
                  .low = 0,
                  .high = kLongestHold,
                  .hold = true}},
      .outputs = {{.name = "out",
                   .unit = "",
                   .doc = "fires at the rise",
                   .kind = OutputKind::Trigger,
                   .range = {0, 1}},
                  {.name = "gate", .unit = "", .doc = "1 while high", .range = {0, 1}}},
      .make = make_node<Threshold>,
      .skips_unread = true,
  };
  return type;
}

}  // namespace tactus
