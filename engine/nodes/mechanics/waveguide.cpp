#include "engine/dsp/strings/string_loop.h"
#include "engine/nodes/declare.h"
#include "engine/nodes/delays/string_setup.h"
#include "engine/nodes/process.h"

namespace tactus {
namespace {

static_assert(WaveLine::kMostFrames >= kMaxSubBlock);

class WaveguideNode final : public Node {
  enum Input { kWave, kPitch, kGain, kLoss };

 public:
  explicit WaveguideNode(const NodeSetup& setup)
      : line_(loss_filter_of(setup), setup.setting("end").text == "free" ? FarEnd::Free : FarEnd::Fixed,
              setup.sample_rate, {pitches_of(setup).low, pitches_of(setup).high}) {}

  void process(const NodeBlock& block) noexcept override {
    absorb(block);
    read(block, block.frames);
  }
  void emit(const NodeBlock& block) noexcept override { read(block, 0); }
  void absorb(const NodeBlock& block) noexcept override {
    Contiguous wave;
    line_.write(wave(block.in[kWave], block.frames), block.frames);
  }
  void reset() noexcept override {
    line_.reset();
    steps_.reset();
  }
  void copy(const Node& other) noexcept override { assign(*this, other); }
  void adopt(const Node& before) noexcept override {
    if (const auto* other = dynamic_cast<const WaveguideNode*>(&before)) line_.adopt(other->line_);
  }

  DelayRange delay(int input, int) const override {
    return input == kWave ? DelayRange{line_.least_delay(), line_.most_delay()} : DelayRange{};
  }

  std::optional<std::complex<double>> response(int input, int, std::complex<double> z,
                                               std::span<const double> at) const override {
    if (input != kWave) return std::nullopt;
    return line_.response({.pitch_hz = at[kPitch], .gain = at[kGain], .loss = at[kLoss]}, 1.0 / z);
  }

 private:
  void read(const NodeBlock& block, int written) noexcept {
    const auto* in = block.in;
    steps_.run(
        block, all_constant(block, kPitch, 3),
        [&](int n) { line_.tune({.pitch_hz = in[kPitch][n], .gain = in[kGain][n], .loss = in[kLoss][n]}); },
        [&](int from, int to, int position) {
          line_.read(block.out[0] + from, to - from, written - from, position);
        });
  }

  WaveLine line_;
  GroupSteps steps_;
};

}  // namespace

NodeType waveguide_type() {
  return {
      .name = "waveguide",
      .summary =
          "A string or rod, driven at one end by a network's `port`: waves travel to the far end and return.",
      .equation =
          "out[n] = +-gain (h_LP * wave)[n - (N - 1)]: + from a fixed end, - from a free one\nN = fs/pitch + "
          "arg H_LP(w)/w,  w = 2 pi pitch/fs; the remaining frame is the delay of the port\nH_LP = (1 - "
          "loss/2) + loss/2 z^-1 (one_zero) or (1 - loss) / (1 - loss z^-1) (one_pole)\nImpedance of the "
          "port: sqrt(T M) for a string of tension T and mass per metre M, A sqrt(E rho) for a rod. A fixed "
          "string on a heavy mass sounds at `pitch`; on a mass m at w m = Z cot(w / (2 pitch)). It is "
          "passive; gain = 0: an endless line",
      .source =
          "J. O. Smith, Physical Audio Signal Processing, 2010; Jaffe & Smith, Computer Music Journal "
          "7(2), 1983",
      .example = "{ type = \"waveguide\", wave = \"bridge.nut.wave\", pitch = \"220 Hz\", gain = 0.998 }",
      .inputs = {late({"wave", "any", "incoming wave: the `wave` of a network's port"}),
                 pitch_input(
                     "reciprocal of the travel time to the far end and back; at most 0.2 of the sample rate"),
                 {"gain", "",
                  "gain of the travel to the far end and back; 0: an endless line without reflection", 0.998,
                  0, 1},
                 loss_input()},
      .outputs = {{"out", "=wave", "returning wave"}},
      .silencers = {{"wave"}},
      .settings = {choice("end", "termination of the far end", {"fixed", "free"}, "fixed"),
                   loss_filter_setting()},
      .make = make_node<WaveguideNode>};
}

}  // namespace tactus
