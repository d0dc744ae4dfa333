#include <algorithm>

#include "engine/nodes/declare.h"
#include "engine/nodes/envelopes/pitch_kernel.h"

namespace tactus {
namespace {

class PitchNode final : public Node {
 public:
  explicit PitchNode(const tactus_pitch& start)
      : start_(start),
        state_(start),
        full_(2 * index(start.full_frames)),
        small_(2 * index(start.small_frames)) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal in = block.in[0], clarity = block.in[1];
    for (int n = 0; n < block.frames; ++n) {
      tactus_pitch_step(&state_, full_.data(), small_.data(), in[n]);
      if (state_.clarity >= clarity[n] && state_.clarity > 0) held_ = state_.frequency;
      block.out[0][n] = held_;
      block.out[1][n] = state_.clarity >= clarity[n] && state_.clarity > 0;
      block.out[2][n] = state_.clarity;
    }
  }
  void reset() noexcept override {
    state_ = start_;
    held_ = 0;
    std::ranges::fill(full_, 0.0);
    std::ranges::fill(small_, 0.0);
  }
  void copy(const Node& other) noexcept override {
    const auto* same = dynamic_cast<const PitchNode*>(&other);
    if (same == nullptr || same->full_.size() != full_.size() || same->small_.size() != small_.size()) return;
    state_ = same->state_;
    held_ = same->held_;
    std::ranges::copy(same->full_, full_.begin());
    std::ranges::copy(same->small_, small_.begin());
  }

 private:
  tactus_pitch start_, state_;
  std::vector<double> full_, small_;
  double held_ = 0;
};

Result<std::unique_ptr<Node>> make_pitch(const NodeSetup& setup) {
  const double lowest = *setup.inputs[2].constant, highest = std::max(2 * lowest, *setup.inputs[3].constant);
  tactus_pitch start{};
  tactus_pitch_start(&start, setup.sample_rate.value, lowest, highest);
  const auto fits = setup.take_memory(2 * index(start.full_frames + start.small_frames));
  if (!fits) return tl::unexpected<Error>(fits.error());
  return std::make_unique<PitchNode>(start);
}

}  // namespace

NodeType pitch_type() {
  return {
      .name = "pitch",
      .summary =
          "Follows the pitch of a signal: the frequency at which it repeats itself, found anew every 5 ms.",
      .equation =
          "n(t) = 2 sum x[j] x[j - t] / sum (x[j]^2 + x[j - t]^2) over the last period and a little more; "
          "out = 1 / "
          "the first t of a maximum of n above 0.9 of the highest, clarity = n there.\nNeeds the last two "
          "periods, so it "
          "is up to two periods and 5 ms late",
      .source = "McLeod & Wyvill, ICMC 2005",
      .example = "sung = { type = \"pitch\", in = \"microphone\", lowest = \"80 Hz\", highest = \"800 Hz\" }",
      .inputs = {{"in", "any", "signal"},
                 {"clarity", "", "least clarity of a pitch; 1: an exact repetition", 0.85, 0, 1},
                 fixed({"lowest", "Hz", "lowest pitch", 60, 20, 2000}),
                 fixed({"highest", "Hz",
                        "highest pitch; at least an octave above `lowest`, to which a lower value is raised",
                        1000, 40, 8000})},
      .outputs = {bounded(0, 1e5, {"out", "Hz", "the last pitch that was clear enough; 0 before the first"}),
                  bounded(0, 1, {"gate", "", "1 while the pitch is clear enough"}),
                  bounded(0, 1, {"clarity", "", "how exactly the signal repeats itself"})},
      .make = make_pitch,
  };
}

}  // namespace tactus
