#include "engine/nodes/declare.h"
#include "engine/nodes/delays/string_setup.h"
#include "engine/nodes/process.h"

namespace tactus {
namespace {

/// One string, or eight of them in vector registers.
template <int Width = 1>
class StringNode final : public Node {
  enum Input { kIn, kPitch, kGain, kLoss };

 public:
  StringNode(LossFilter filter, Hertz sample_rate, double lowest_pitch)
      : filter_(filter),
        sample_rate_(sample_rate),
        lowest_pitch_(lowest_pitch),
        string_(filter, sample_rate, lowest_pitch) {}
  explicit StringNode(const NodeSetup& setup)
      // Above 0.3 of the rate the pitch is clamped to that.
      : StringNode(loss_filter_of(setup), setup.sample_rate,
                   std::min(pitches_of(setup).low, 0.3 * setup.sample_rate.value)) {}

  void process(const NodeBlock& block) noexcept override {
    if constexpr (Width == 1) {
      if (block.frames == 1) {
        const int position = steps_.single(block, [&](int n) { tune(block, n); });
        *block.out[0] = string_.run_single(*block.in[kIn].data, position);
        return;
      }
    }
    process_frames(block);
  }

  void adopt(const Node& before) noexcept override {
    if (const auto* other = dynamic_cast<const StringNode*>(&before)) string_.adopt(other->string_);
  }

  void reset() noexcept override {
    string_.reset();
    steps_.reset();
  }
  void copy(const Node& other) noexcept override { assign(*this, other); }

  std::unique_ptr<Node> vectorised(std::span<const Node* const> lanes) const override {
    double lowest = lowest_pitch_;
    for (const auto* lane : lanes)
      if (lane != nullptr) lowest = std::min(lowest, static_cast<const StringNode*>(lane)->lowest_pitch_);
    return std::make_unique<StringNode<kVectorWidth>>(filter_, sample_rate_, lowest);
  }

  std::optional<std::complex<double>> response(int input, int, std::complex<double> z,
                                               std::span<const double> at) const override {
    if (input != kIn) return std::nullopt;
    const StringDesign design{
        {.pitch_hz = within_range(at[kPitch]), .gain = at[kGain], .loss = at[kLoss]}, filter_, sample_rate_};
    return design.response(1.0 / z);
  }

 private:
  /// NaN becomes the lowest: the line is no longer than for that.
  double within_range(double pitch) const noexcept {
    return std::min(std::max(lowest_pitch_, pitch), StringLoop::kHighestPitch);
  }

  void tune(const NodeBlock& block, int n) noexcept {
    for (int lane = 0; lane < Width; ++lane) {
      const auto in = [&](Input input) { return VectorSignal{block.in[input]}.lane(lane, n); };
      string_.tune({.pitch_hz = within_range(in(kPitch)), .gain = in(kGain), .loss = in(kLoss)}, lane);
    }
  }

  // Not inlined: the setup for many frames would delay a single one.
  [[gnu::noinline]] void process_frames(const NodeBlock& block) noexcept {
    Contiguous contiguous;
    const auto x = run_input<Width>(block, contiguous);
    steps_.run(
        block, all_constant(block, kPitch, 3), [&](int n) { tune(block, n); },
        [&](int from, int to, int position) {
          string_.run(x + from, block.out[0] + from * Width, to - from, position);
        });
  }

  LossFilter filter_;
  Hertz sample_rate_;
  double lowest_pitch_;
  std::conditional_t<Width == 1, StringLoop, VectorStringLoop> string_;
  GroupSteps steps_;
};

}  // namespace

NodeType string_type() {
  return {
      .name = "string",
      .summary = "A lightly damped string: a tuned loop of a delay and losses, driven by its input.",
      .equation =
          "out[n] = in[n] + gain (h_LP * out)[n - N],  N = fs/pitch + arg H_LP(w)/w,  w = 2 pi pitch/fs\n"
          "H_LP = (1 - loss/2) + loss/2 z^-1 (one_zero) or (1 - loss) / (1 - loss z^-1) (one_pole)\n"
          "T60 of a partial = 3 ln(10) N / (-ln(gain |H_LP|) fs)",
      .source = "Jaffe & Smith, Computer Music Journal 7(2), 1983; Laakso et al., IEEE SP Magazine 13, 1996",
      .example = "{ type = \"string\", in = \"bow\", pitch = \"220 Hz\", gain = 0.995 }",
      .inputs = {filtered_input("excitation of the string"),
                 pitch_input("fundamental frequency; at most 0.3 of the sample rate"),
                 {"gain", "", "gain of one pass through the loop", 0.99, 0, 0.9999},
                 loss_input()},
      .outputs = {filtered_output("out", "signal of the string at the driven point")},
      .silencers = {{"in"}},
      .settings = {loss_filter_setting()},
      .make = make_node<StringNode<>>,
      .resonant = true};
}

}  // namespace tactus
