#include <algorithm>

#include "engine/nodes/make.h"
#include "engine/nodes/shapers/shapers.h"
#include "engine/nodes/shapers/slew_kernel.h"

namespace tactus {
namespace {

struct Slew {
  static constexpr int kInputs = 3;
  explicit Slew(const NodeSetup& setup) : frame_s(1 / setup.sample_rate.value) {}
  double step(const double* in) { return tactus_slew_step(&state, in[0], in[1], in[2], frame_s); }

  double frame_s;
  tactus_slew state{};
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
      .make = make_node<KernelNode<Slew>>,
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
