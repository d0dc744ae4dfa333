#include "engine/dsp/delays/delay_line.h"
#include "engine/dsp/delays/taps.h"
#include "engine/dsp/envelopes/envelope_kernel.h"
#include "engine/graph/file/quantity.h"
#include "engine/nodes/declare.h"
#include "engine/nodes/delays/align_kernel.h"
#include "engine/nodes/process.h"

namespace tactus {
namespace {

class AlignNode final : public Node {
 public:
  enum Input { kIn, kPeriod, kDelay, kPhase, kTrigger, kOn };

  explicit AlignNode(const NodeSetup& setup)
      : start_(start_of(setup)),
        state_(start_),
        line_(tactus_delay_most(&start_.delay, kOrder) + kOrder + kMaxSubBlock, kMaxSubBlock + kOrder) {}

  static Result<std::unique_ptr<Node>> make(const NodeSetup& setup) {
    const double longest = std::min(setup.input("period").range.high, TACTUS_ALIGN_LONGEST);
    if (longest * setup.sample_rate.value < 2)
      return fail(Errc::OutOfRange, {},
                  "its period is always shorter than two frames, " +
                      short_quantity(2 / setup.sample_rate.value, parse_unit("s")->dimension),
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
    for (int n = 0; n < block.frames; ++n)
      block.out[0][n] = tactus_align_read(&state_, line_.line(), block.frames - n, in[kPeriod][n],
                                          in[kDelay][n], in[kPhase][n], in[kTrigger][n], in[kOn][n]);
  }

  void reset() noexcept override {
    line_.reset();
    state_ = start_;
  }
  void copy(const Node& other) noexcept override { assign(*this, other); }
  void adopt(const Node& before) noexcept override {
    if (const auto* other = dynamic_cast<const AlignNode*>(&before)) line_.adopt(other->line_);
  }

  DelayRange delay(int input, int) const override {
    if (input != kIn) return {};
    return {tactus_delay_least(&start_.delay, kOrder), tactus_delay_most(&start_.delay, kOrder)};
  }

  /// As a note that starts with these inputs.
  std::optional<std::complex<double>> response(int input, int, std::complex<double> z,
                                               std::span<const double> at) const override {
    if (input != kIn) return std::nullopt;
    if (at[kOn] < 0.5) return 1.0;
    const double period = tactus_align_period(&start_, at[kPeriod]);
    const double rest = tactus_align_rest(period, at[kDelay], at[kPhase]);
    const double turns = tactus_align_turns(&start_, period, rest);
    return delay_response<kOrder>(start_.delay, tactus_delay_inside(&start_.delay, turns * period - rest), z);
  }

 private:
  static constexpr int kOrder = TACTUS_ALIGN_TAPS - 1;

  static tactus_align start_of(const NodeSetup& setup) {
    tactus_align start{};
    tactus_align_start(&start, setup.sample_rate.value, setup.input("period").range.high);
    return start;
  }

  tactus_align start_, state_;
  DelayLine line_;
};

}  // namespace

NodeType align_type() {
  return {
      .name = "align",
      .summary =
          "Adds delay to a loop that is slower than the note, so that the loop delay is a whole number of "
          "periods.",
      .equation =
          "out[n] = in(n - pad fs),  pad = k period - delay - sum of phase delays + phase period / (2 pi)\n"
          "k: the smallest with a pad of at least one frame, chosen at each note start (a trigger, or a "
          "period jump of half a semitone). The pad then follows the period, up to 1.5 periods and one "
          "frame; beyond that, k changes with a crossfade of 10 ms (gains add up to 1)",
      .source =
          "condition of oscillation: the loop phase is a multiple of 360 degrees (Barkhausen); the loop: "
          "Berdahl, Steiner & Oldham, NIME 2008, section 7.2",
      .example = "{ type = \"align\", in = \"string\", period = \"1 / pitch\", delay = \"system.delay\" }",
      .inputs = {{"in", "any", "signal in the loop"},
                 {"period", "s", "period of the note; at most 0.1 s", {}, 0, TACTUS_ALIGN_LONGEST},
                 {"delay",
                  "s",
                  "delay already present in the loop; in an instrument, usually system.delay; below 0 where "
                  "it leads, as a high-pass does",
                  {},
                  -TACTUS_ALIGN_MOST_REST,
                  TACTUS_ALIGN_MOST_REST},
                 {"phase", "rad",
                  "phase of the rest of the loop at the pitch, as measured for a shaker and a sensor; "
                  "negative: lags",
                  0, -TACTUS_ALIGN_MOST_REST, TACTUS_ALIGN_MOST_REST},
                 {"trigger", "", "start of a note", 0},
                 {"on", "", "below 0.5 no delay is added: the input passes unchanged", 1}},
      .outputs = {{"out", "=in", "the input, delayed"}},
      .settings = {{"compensate", Setting::Kind::Names,
                    "filters in the same loop, or models of hardware in it; their phase delays at "
                    "the pitch count as part of the loop delay"}},
      .make = AlignNode::make,
      .compensation = PhaseCompensation{.port = AlignNode::kDelay, .period = AlignNode::kPeriod, .sign = 1}};
}

}  // namespace tactus
