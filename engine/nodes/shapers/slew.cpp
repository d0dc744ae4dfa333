#include <algorithm>

#include "engine/nodes/make.h"
#include "engine/nodes/shapers/shapers.h"

namespace tactus {
namespace {

class Slew final : public Node {
 public:
  explicit Slew(const NodeSetup& setup) : frame_s_(1 / setup.sample_rate.value) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal in = block.in[0], rise = block.in[1], fall = block.in[2];
    for (int i = 0; i < block.frames; ++i) {
      // Signals may be outside the declared range, which constants cannot be.
      const double up = std::max(0.0, rise[i]) * frame_s_;
      const double down = std::max(0.0, fall[i]) * frame_s_;
      last_ = std::clamp(in[i], last_ - down, last_ + up);
      block.out[0][i] = last_;
    }
  }
  void reset() noexcept override { last_ = 0; }

 private:
  double frame_s_;
  double last_ = 0;
};

}  // namespace

const NodeType& slew_type() {
  static const NodeType type = {
      .name = "slew",
      .group = "shapers",
      .summary = "Follows a signal no faster than a given rate, from 0 on.",
      .equation = "out[n] = max(out[n - 1] - fall / rate, min(out[n - 1] + rise / rate, in[n]))",
      .source = "the slew rate of an amplifier, Horowitz & Hill, The Art of Electronics, 3rd ed. 2015",
      .example = "push = { type = \"slew\", in = \"target\", rise = \"20 N/s\", fall = \"5 N/s\" }",
      .inputs = {{.name = "in", .unit = "any", .doc = "signal"},
                 {.name = "rise", .unit = "=in/s", .doc = "fastest way up", .low = 0},
                 {.name = "fall", .unit = "=in/s", .doc = "fastest way down", .low = 0}},
      .outputs = {{.name = "out", .unit = "=in", .doc = "signal without jumps"}},
      .make = make_node<Slew>,
      .small_signal_gain = 1,
      // It starts at 0 and then lies between where it was and where it goes.
      .range =
          [](int, const NodeSetup& setup) {
            const auto in = setup.input("in").range;
            return Interval{std::min(0.0, in.low), std::max(0.0, in.high)};
          },
  };
  return type;
}

}  // namespace tactus
