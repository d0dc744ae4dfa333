#include <cmath>
#include <utility>

#include "engine/core/dimension.h"
#include "engine/dsp/delays/delay_line.h"
#include "engine/dsp/delays/taps.h"
#include "engine/nodes/delays/delays.h"
#include "engine/nodes/delays/wide_delay_node.h"
#include "engine/nodes/group_steps.h"

namespace tactus {
namespace {

enum Input { kIn, kTime };

constexpr double kDelayMostFrames = 1 << 24;

/// What delays of every order have in common.
class RememberingNode : public Node {
 public:
  explicit RememberingNode(DelayLine line) : line_(std::move(line)) {}
  void adopt(Node& before) noexcept override {
    if (auto* other = dynamic_cast<RememberingNode*>(&before)) line_.adopt(other->line_);
  }

 protected:
  DelayLine line_;
};

/// Reads `Order` + 1 taps; order 0 is the nearest whole frame.
template <int Order>
class DelayNode : public RememberingNode {
 public:
  explicit DelayNode(const DelayTaps<Order>& taps)
      : RememberingNode(DelayLine{taps.longest() + kMaxSubBlock, kMaxSubBlock + Order}),
        taps_(taps),
        aim_(taps_.at(taps_.range().low_s)) {}

  void process(const NodeBlock& block) noexcept override {
    absorb(block);
    read(block, block.frames);
  }
  void emit(const NodeBlock& block) noexcept override { read(block, 0); }
  void absorb(const NodeBlock& block) noexcept override {
    InARow in_a_row;
    line_.write(in_a_row(block.in[kIn], block.frames), block.frames);
  }
  void reset() noexcept override {
    line_.reset();
    clamped_ = 0;
  }

  DelayRange delay(int input, int) const override { return input == kIn ? taps_.delay() : DelayRange{}; }

  std::optional<std::complex<double>> response(int input, int, std::complex<double> z,
                                               std::span<const double> at) const override {
    if (input != kIn) return std::nullopt;
    return taps_.response(taps_.inside(at[kTime]), z);
  }

  std::unique_ptr<Node> vectorised(std::span<const Node* const> lanes) const override {
    std::vector<DelayTaps<Order>> taps;
    std::array<bool, kVectorWidth> used{};
    for (std::size_t lane = 0; lane < kVectorWidth; ++lane) {
      used[lane] = lanes[lane] != nullptr;
      taps.push_back(static_cast<const DelayNode*>(used[lane] ? lanes[lane] : this)->taps_);
    }
    return std::make_unique<WideDelayNode<Order>>(std::move(taps), used);
  }

  std::int64_t clamped() const override { return clamped_; }

 private:
  void read(const NodeBlock& block, int written) noexcept {
    const auto time = block.in[kTime];
    double* y = block.out[0];
    if (steady(time, block.frames)) {
      const double seconds = counted(time[0], block.frames);
      if (seconds != aimed_at_) aim_ = taps_.at(aimed_at_ = seconds);
      const double* newest = newest_tap(aim_, written);
      if constexpr (Order == 0)
        copy_samples(newest, block.frames, y);
      else
        tap_sums(newest, aim_.weights, nullptr, y, block.frames);
      return;
    }
    for (int n = 0; n < block.frames; ++n) {
      const auto aim = taps_.at(counted(time[n], 1));
      const double* newest = newest_tap(aim, written - n);
      y[n] = Order == 0 ? *newest : tap_sum(newest, aim.weights, 0);
    }
  }

  /// Also where a phase delay gives the same in every frame.
  static bool steady(const Signal& time, int frames) noexcept {
    if (time.constant() || frames == 1) return true;
    unsigned changes = 0;
    for (int n = 1; n < frames; ++n) changes |= static_cast<unsigned>(time.data[n] != time.data[0]);
    return changes == 0;
  }

  double counted(double seconds, int frames) noexcept {
    const double possible = taps_.inside(seconds);
    if (possible != seconds) clamped_ += frames;
    return possible;
  }

  const double* newest_tap(const DelayAim<Order>& aim, int written) const noexcept {
    return line_.behind(aim.newest + Order + written) + Order;
  }

  DelayTaps<Order> taps_;
  double aimed_at_ = taps_.range().low_s;
  DelayAim<Order> aim_;
  std::int64_t clamped_ = 0;
};

/// A setting that is a time.
Result<std::optional<double>> time_of(const NodeSetup& setup, std::string_view name) {
  const auto& setting = setup.setting(name);
  if (!setting.given) return std::nullopt;
  const auto quantity = parse_quantity(setting.text);
  const bool time = quantity && (quantity->unit.dimension == Dimension{.second = 1} ||
                                 (quantity->unit.dimension.plain() && !quantity->unit.decibel));
  if (!time || !std::isfinite(quantity->si) || quantity->si < 0)
    return fail(Errc::UnitMismatch, {},
                "'" + std::string(name) + "' of a delay is not a time: \"" + setting.text + '"',
                "give a quantity such as \"20 ms\"");
  return quantity->si;
}

Result<TimeRange> range_of(const NodeSetup& setup) {
  const auto min = time_of(setup, "min");
  if (!min) return tl::unexpected(min.error());
  const auto max = time_of(setup, "max");
  if (!max) return tl::unexpected(max.error());
  const double low = min->value_or(0), high = max->value_or(kUnlimited);
  if (low > high)
    return fail(Errc::OutOfRange, {}, "'min' of a delay is longer than its 'max'", "exchange them");
  const auto known = setup.input("time").range;
  const TimeRange range{std::clamp(known.low, low, high), std::clamp(known.high, low, high)};
  if (!std::isfinite(range.high_s))
    return fail(Errc::OutOfRange, {}, "the longest delay is not known", "give max = \"...\" a time");
  if (range.high_s * setup.sample_rate.value > kDelayMostFrames)
    return fail(Errc::OutOfRange, {},
                "it can be " + std::to_string(std::llround(std::min(range.high_s, 1e15))) +
                    " s long, and the longest delay is " +
                    std::to_string(std::llround(kDelayMostFrames / setup.sample_rate.value)) + " s",
                "shorten 'time', or give 'max'");
  return range;
}

template <int Order>
Result<std::unique_ptr<Node>> made(TimeRange range, Hertz sample_rate) {
  return std::make_unique<DelayNode<Order>>(DelayTaps<Order>{range, sample_rate});
}

Result<std::unique_ptr<Node>> make(const NodeSetup& setup) {
  const auto range = range_of(setup);
  if (!range) return tl::unexpected(range.error());
  const auto frames = static_cast<std::size_t>(std::ceil(range->high_s * setup.sample_rate.value));
  if (const auto fits = setup.take_memory(frames); !fits) return tl::unexpected(fits.error());
  const auto& word = setup.setting("interpolation").text;
  if (word == "none") return made<0>(*range, setup.sample_rate);
  if (word == "linear") return made<1>(*range, setup.sample_rate);
  if (word == "lagrange5") return made<5>(*range, setup.sample_rate);
  return made<3>(*range, setup.sample_rate);
}

}  // namespace

const NodeType& delay_type() {
  static const NodeType type{
      .name = "delay",
      .group = "delays",
      .summary =
          "Gives its input back later; it may close a loop, and its time may change from frame to frame.",
      .equation =
          "out[n] = in(n - time fs), between frames the polynomial through 2, 4 or 6 of them.\n"
          "Below 1 frame (linear), 2 (lagrange3) or 3 (lagrange5) the polynomial is taken outside its middle "
          "interval, since later frames do not exist yet: high frequencies are then passed less exactly and "
          "up "
          "to some dB too loud.\n"
          "Least delay = floor(shortest time fs) less 1 for lagrange3, 2 for lagrange5; at least 1 where the "
          "time is never below a frame",
      .source = "Laakso, Valimaki, Karjalainen & Laine, IEEE SP Magazine 13, 1996",
      .example = "{ type = \"delay\", in = \"string\", time = \"20 ms\" }",
      .inputs = {{.name = "in", .unit = "any", .doc = "signal to delay", .late = true},
                 {.name = "time", .unit = "s", .doc = "how much later", .low = 0}},
      .outputs = {{.name = "out", .unit = "=in", .doc = "what came in `time` ago"}},
      .settings =
          {{.name = "interpolation",
            .kind = Setting::Kind::Choice,
            .doc = "between frames; none rounds to whole ones. lagrange3 is within 0.1 dB up to fs/8, with a "
                   "tap that is one frame newer; lagrange5 up to fs/6 with two, linear up to fs/21",
            .choices = {"none", "linear", "lagrange3", "lagrange5"},
            .fallback = "lagrange3"},
           {.name = "min",
            .kind = Setting::Kind::Text,
            .doc = "shortest time, where the graph does not tell",
            .optional = true},
           {.name = "max",
            .kind = Setting::Kind::Text,
            .doc = "longest time, where the graph does not tell",
            .optional = true},
           {.name = "compensate",
            .kind = Setting::Kind::Names,
            .doc = "filters in the same loop; their phase delays at the frequency 1/time are taken off the "
                   "time, so that the loop is in tune",
            .optional = true}},
      .make = make,
      .compensation = PhaseCompensation{.port = kTime, .period = kTime, .sign = -1}};
  return type;
}

}  // namespace tactus
