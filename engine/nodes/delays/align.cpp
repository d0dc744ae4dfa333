#include <cmath>
#include <numbers>

#include "engine/dsp/delays/delay_line.h"
#include "engine/dsp/delays/taps.h"
#include "engine/dsp/envelopes/rise_kernel.h"
#include "engine/graph/file/quantity.h"
#include "engine/nodes/declare.h"
#include "engine/nodes/delays/delay_taps.h"
#include "engine/nodes/process.h"

namespace tactus {
namespace {

constexpr double kLongestPeriod_s = 0.1;  // 10 Hz, the lowest string
constexpr double kAlignFade_s = 0.010;
constexpr double kHalfSemitone = 0.0293;  // 2^(1/24) - 1

/// Delay that makes a loop a whole number of periods long at its pitch:
///
///   pad = k P − rest,   rest = delay − phase P / 2π
///
/// P [s] is one period, `delay` [s] what the loop takes without the pad, `phase` [rad] what turns in it
/// besides (below 0 it lags). k is chosen when a note starts, the least with a pad of at least `shortest`;
/// after that the pad follows P with the same k, from `shortest` to `shortest` + 1.5 P: so wide that a
/// vibrato at one end of it moves to the middle and stays there. Source: Berdahl, Steiner & Oldham, NIME
/// 2008, section 7.2, for the loop; k P from the condition of oscillation (Barkhausen).
struct LoopPad {
  double shortest;  ///< [s]

  static double rest(double period, double delay, double phase) noexcept {
    return delay - phase * period / (2 * std::numbers::pi);
  }
  /// k of a new note.
  double turns(double period, double rest) const noexcept { return std::ceil((rest + shortest) / period); }
  /// Whether k still serves.
  bool serves(double turns, double period, double rest) const noexcept {
    const double pad = turns * period - rest;
    return pad >= shortest && pad <= longest(period);
  }
  double longest(double period) const noexcept { return shortest + 1.5 * period; }
};

/// Two taps on one line: where the pad is, and, while it moves from one number of periods to another, where
/// it was. Their gains add up to 1: at the pitch both are in phase.
class AlignNode final : public Node {
 public:
  enum Input { kIn, kPeriod, kDelay, kPhase, kTrigger, kOn };

  explicit AlignNode(const NodeSetup& setup)
      : frame_s_(1 / setup.sample_rate.value),
        shortest_period_(2 * frame_s_),
        longest_period_(std::clamp(setup.input("period").range.high, shortest_period_, kLongestPeriod_s)),
        pad_{frame_s_},
        taps_(TimeRange{0, pad_.longest(longest_period_)}, setup.sample_rate),
        line_(taps_.longest() + kMaxSubBlock, kMaxSubBlock + kOrder),
        fade_frames_(static_cast<int>(std::lround(kAlignFade_s / frame_s_))) {}

  static Result<std::unique_ptr<Node>> make(const NodeSetup& setup) {
    const double longest = std::min(setup.input("period").range.high, kLongestPeriod_s);
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
    Contiguous in;
    line_.write(in(block.in[kIn], block.frames), block.frames);
    for (int n = 0; n < block.frames; ++n) {
      follow(block, n);
      const int written = block.frames - n;
      double y = tap(now_, written);
      if (fading_ > 0) y += static_cast<double>(fading_--) / fade_frames_ * (tap(before_, written) - y);
      block.out[0][n] = y;
    }
  }

  void reset() noexcept override {
    line_.reset();
    rise_ = {};
    started_ = note_ = on_ = false;
    period_ = pad_s_ = turns_ = 0;
    fading_ = 0;
    now_ = before_ = {};
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
    const double period = possible(at[kPeriod]);
    const double rest = LoopPad::rest(period, at[kDelay], at[kPhase]);
    return taps_.response(taps_.inside(pad_.turns(period, rest) * period - rest), z);
  }

 private:
  static constexpr int kOrder = 3;

  double possible(double period) const noexcept {
    return std::clamp(period, shortest_period_, longest_period_);
  }

  void follow(const NodeBlock& block, int n) noexcept {
    const double period = possible(block.in[kPeriod][n]);
    const double rest = LoopPad::rest(period, block.in[kDelay][n], block.in[kPhase][n]);
    const bool on = block.in[kOn][n] >= 0.5;
    const bool jumped =
        std::max(period, period_) > (1 + kHalfSemitone) * std::min(period, period_) && started_;
    note_ |= tactus_rise_step(&rise_, block.in[kTrigger][n]) != 0 || jumped;
    period_ = period;
    const bool moves = !started_ || note_ || on != on_ || !pad_.serves(turns_, period, rest);
    // While one move is under way, a new note has to wait.
    if (moves && fading_ == 0) move(on, period, rest);
    if (!note_) aim(on_ ? turns_ * period - rest : 0);
  }

  void move(bool on, double period, double rest) noexcept {
    const double pad_before = pad_s_;
    on_ = on;
    turns_ = pad_.turns(period, rest);
    note_ = false;
    before_ = now_;
    aim(on ? turns_ * period - rest : 0);
    if (started_ && pad_s_ != pad_before) fading_ = fade_frames_;
    started_ = true;
  }

  void aim(double pad_s) noexcept {
    const double inside = taps_.inside(pad_s);
    if (inside != pad_s_) now_ = taps_.at(pad_s_ = inside);
  }

  double tap(const DelayAim<kOrder>& aim, int written) const noexcept {
    return tap_sum(line_.behind(aim.newest + kOrder + written) + kOrder, aim.weights, 0);
  }

  double frame_s_, shortest_period_, longest_period_;
  LoopPad pad_;
  DelayTaps<kOrder> taps_;
  DelayLine line_;
  int fade_frames_;
  tactus_rise rise_{};
  bool started_ = false, note_ = false, on_ = false;
  double period_ = 0, pad_s_ = 0, turns_ = 0;
  int fading_ = 0;  ///< frames left
  DelayAim<kOrder> now_, before_;
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
                 {"period", "s", "period of the note; at most 0.1 s", {}, 0, kLongestPeriod_s},
                 {"delay",
                  "s",
                  "delay already present in the loop; in an instrument, usually system.delay",
                  {},
                  0,
                  1000},
                 {"phase", "rad",
                  "phase of the rest of the loop at the pitch, as measured for a shaker and a sensor; "
                  "negative: lags",
                  0, -1000, 1000},
                 {"trigger", "", "start of a note", 0},
                 {"on", "", "below 0.5 no delay is added: the input passes unchanged", 1}},
      .outputs = {{"out", "=in", "the input, delayed"}},
      .settings = {optional({"compensate", Setting::Kind::Names,
                             "filters in the same loop, or models of hardware in it; their phase delays at "
                             "the pitch count as part of the loop delay"})},
      .make = AlignNode::make,
      .compensation = PhaseCompensation{.port = AlignNode::kDelay, .period = AlignNode::kPeriod, .sign = 1}};
}

}  // namespace tactus
