#include "engine/dsp/delays/delay_line.h"
#include "engine/dsp/delays/taps.h"
#include "engine/nodes/declare.h"
#include "engine/nodes/delays/align_kernel.h"
#include "engine/nodes/delays/delay_taps.h"
#include "engine/nodes/process.h"

namespace tactus {
namespace {

class AlignNode final : public Node {
 public:
  enum Input { kIn, kPeriod, kDelay, kPhase, kTrigger, kOn };

  explicit AlignNode(const NodeSetup& setup)
      : start_(start_of(setup)),
        state_(start_),
        taps_(TimeRange{0, tactus_align_longest_pad(&start_, start_.longest_period)}, setup.sample_rate),
        line_(taps_.longest() + kMaxSubBlock, kMaxSubBlock + kOrder) {}

  static Result<std::unique_ptr<Node>> make(const NodeSetup& setup) {
    const double longest = std::min(setup.input("period").range.high, TACTUS_ALIGN_LONGEST);
    if (longest * setup.sample_rate.value < 2)
      return fail(Errc::OutOfRange, {}, "its period is never as long as two frames",
                  "give the period of the note, as in period = \"1 / pitch\"");
    const double frames = 1.5 * longest * setup.sample_rate.value;
    if (const auto fits = setup.take_memory(static_cast<std::size_t>(frames)); !fits)
      return tl::unexpected(fits.error());
    return std::make_unique<AlignNode>(setup);
  }

  void process(const NodeBlock& block) noexcept override {
    const auto* in = block.in;
    Contiguous samples;
    line_.write(samples(in[kIn], block.frames), block.frames);
    for (int n = 0; n < block.frames; ++n) {
      tactus_align_follow(&state_, in[kPeriod][n], in[kDelay][n], in[kPhase][n], in[kTrigger][n], in[kOn][n]);
      const int written = block.frames - n;
      double y = sum(state_.now, written);
      if (state_.fading > 0) y += tactus_align_fade(&state_) * (sum(state_.before, written) - y);
      block.out[0][n] = y;
    }
  }

  void reset() noexcept override {
    line_.reset();
    state_ = start_;
  }
  void adopt(Node& before) noexcept override {
    if (auto* other = dynamic_cast<AlignNode*>(&before)) line_.adopt(other->line_);
  }

  DelayRange delay(int input, int) const override { return input == kIn ? taps_.delay() : DelayRange{}; }

  /// As a note that starts with these inputs.
  std::optional<std::complex<double>> response(int input, int, std::complex<double> z,
                                               std::span<const double> at) const override {
    if (input != kIn) return std::nullopt;
    if (at[kOn] < 0.5) return 1.0;
    const double period = tactus_align_period(&start_, at[kPeriod]);
    const double rest = tactus_align_rest(period, at[kDelay], at[kPhase]);
    const double turns = tactus_align_turns(&start_, period, rest);
    return taps_.response(tactus_align_inside(&start_, turns * period - rest), z);
  }

 private:
  static constexpr int kOrder = TACTUS_ALIGN_TAPS - 1;

  static tactus_align start_of(const NodeSetup& setup) {
    tactus_align start{};
    tactus_align_start(&start, setup.sample_rate.value, setup.input("period").range.high);
    return start;
  }

  double sum(const tactus_align_taps& taps, int written) const noexcept {
    const double *newest = line_.behind(taps.newest + kOrder + written) + kOrder, *weights = taps.weights;
    return tap_sum<TACTUS_ALIGN_TAPS>([=](std::size_t k) { return weights[k]; },
                                      [=](std::size_t k) { return *(newest - k); }, 0.0);
  }

  tactus_align start_, state_;
  DelayTaps<kOrder> taps_;
  DelayLine line_;
};

}  // namespace

NodeType align_type() {
  return {
      .name = "align",
      .summary =
          "Pads a loop that is slower than the note, so that once around it is a whole number of periods.",
      .equation =
          "out[n] = in(n - pad fs),  pad = k period - delay - sum of phase delays + phase period / (2 pi)\n"
          "k: the least with a pad of a frame or more, chosen when a note starts, at a trigger or where the "
          "period jumps by half a semitone. The pad then follows the period, up to 1.5 periods and a frame; "
          "beyond, k moves by what is needed, faded over 10 ms (gains that add up to 1)",
      .source =
          "condition of oscillation: the phase once around is a whole turn (Barkhausen); the loop: Berdahl, "
          "Steiner & Oldham, NIME 2008, section 7.2",
      .example = "{ type = \"align\", in = \"string\", period = \"1 / pitch\", delay = \"system.delay\" }",
      .inputs = {{"in", "any", "signal that goes around"},
                 {"period", "s", "of the note; at most 0.1 s", {}, 0, TACTUS_ALIGN_LONGEST},
                 {"delay", "s", "what the loop takes already; of an instrument system.delay", {}, 0, 1000},
                 {"phase", "rad",
                  "of what else lies in the loop, at the pitch: of a shaker and a sensor, measured; below 0 "
                  "it lags",
                  0, -1000, 1000},
                 {"trigger", "", "a note starts", 0},
                 {"on", "", "below 0.5 nothing is padded: what comes in goes out", 1}},
      .outputs = {{"out", "=in", "what came in, so much later"}},
      .settings = {optional(
          {"compensate", Setting::Kind::Names,
           "filters in the same loop, or models of what lies outside; their phase delays at "
           "the pitch count as part of the loop"})},
      .make = AlignNode::make,
      .compensation = PhaseCompensation{.port = AlignNode::kDelay, .period = AlignNode::kPeriod, .sign = 1}};
}

}  // namespace tactus
