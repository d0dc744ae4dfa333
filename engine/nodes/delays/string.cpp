#include <algorithm>

#include "engine/dsp/strings/string_loop.h"
#include "engine/nodes/delays/delays.h"
#include "engine/nodes/delays/string_ports.h"
#include "engine/nodes/delays/wide_string_node.h"
#include "engine/nodes/filters/filter_ports.h"
#include "engine/nodes/group_steps.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

enum Input { kIn, kPitch, kGain, kLoss };

class StringNode : public Node {
 public:
  explicit StringNode(const NodeSetup& setup)
      : filter_(loss_filter_of(setup)),
        sample_rate_(setup.sample_rate),
        lowest_pitch_(lowest_pitch(setup)),
        string_(filter_, setup.sample_rate, lowest_pitch_) {}

  void process(const NodeBlock& block) noexcept override {
    if (block.frames > 1) return process_row(block);
    const int position = steps_.single(block, [&] { tune(block, 0); });
    *block.out[0] = string_.run_single(*block.in[kIn].data, position);
  }

  void adopt(Node& before) noexcept override {
    if (auto* other = dynamic_cast<StringNode*>(&before)) string_.adopt(other->string_);
  }

  void reset() noexcept override {
    string_.reset();
    steps_.reset();
  }

  std::unique_ptr<Node> vectorised(std::span<const Node* const> lanes) const override {
    double lowest = lowest_pitch_;
    for (const auto* lane : lanes)
      if (lane != nullptr) lowest = std::min(lowest, static_cast<const StringNode*>(lane)->lowest_pitch_);
    return std::make_unique<WideStringNode>(filter_, sample_rate_, lowest);
  }

  std::optional<std::complex<double>> response(int input, int, std::complex<double> z,
                                               std::span<const double> at) const override {
    if (input != kIn) return std::nullopt;
    const StringDesign design{
        {.pitch_hz = at[kPitch], .gain = at[kGain], .loss = at[kLoss]}, filter_, sample_rate_};
    return design.response(1.0 / z);
  }

 private:
  static double lowest_pitch(const NodeSetup& setup) {
    // Above 0.3 of the rate the pitch is clamped to that.
    return std::min(setup.input("pitch").range.low, 0.3 * setup.sample_rate.value);
  }

  void tune(const NodeBlock& block, int n) noexcept {
    const auto* in = block.in;
    string_.tune(
        {.pitch_hz = std::max(lowest_pitch_, in[kPitch][n]), .gain = in[kGain][n], .loss = in[kLoss][n]});
  }

  // Not inlined: what many frames need to be set up would delay a single one.
  [[gnu::noinline]] void process_row(const NodeBlock& block) noexcept {
    InARow in_a_row;
    const double* x = in_a_row(block.in[kIn], block.frames);
    double* y = block.out[0];
    steps_.go(
        block, rest(block, kPitch, 3), [&](int n) { tune(block, n); },
        [&](int from, int to, int position) { string_.run(x + from, y + from, to - from, position); });
  }

  LossFilter filter_;
  Hertz sample_rate_;
  double lowest_pitch_;
  StringLoop string_;
  GroupSteps steps_;
};

}  // namespace

const NodeType& string_type() {
  static const NodeType type{
      .name = "string",
      .group = "delays",
      .summary = "A lightly damped string: a tuned loop of delay and losses, driven by its input.",
      .equation =
          "out[n] = in[n] + gain (h_LP * out)[n - N],  N = fs/pitch + arg H_LP(w)/w,  w = 2 pi pitch/fs\n"
          "H_LP = (1 - loss/2) + loss/2 z^-1 (one_zero) or (1 - loss) / (1 - loss z^-1) (one_pole)\n"
          "T60 of a partial = 3 ln(10) N / (-ln(gain |H_LP|) fs)",
      .source = "Jaffe & Smith, Computer Music Journal 7(2), 1983; Laakso et al., IEEE SP Magazine 13, 1996",
      .example = "{ type = \"string\", in = \"bow\", pitch = \"220 Hz\", gain = 0.995 }",
      .inputs = {filtered_input("what excites the string"),
                 pitch_input("of the fundamental; at most 0.3 of the sample rate"),
                 {.name = "gain",
                  .unit = "",
                  .doc = "once around the loop",
                  .fallback = 0.99,
                  .low = 0,
                  .high = 0.9999},
                 loss_input()},
      .outputs = {filtered_output("out", "the string where it is driven")},
      .settings = {loss_filter_setting()},
      .make = make_node<StringNode>,
      .resonant = true};
  return type;
}

}  // namespace tactus
