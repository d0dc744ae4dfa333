#include <cmath>

#include "engine/core/dimension.h"
#include "engine/dsp/delays/delay_line.h"
#include "engine/dsp/delays/taps.h"
#include "engine/nodes/declare.h"
#include "engine/nodes/delays/delay_setup.h"
#include "engine/nodes/process.h"

namespace tactus {
namespace {

constexpr double kDelayMostFrames = 1 << 24;
constexpr int kDelayTime = 1;  ///< the input

/// What delays of every order have in common.
template <int Width>
class DelayMemory : public Node {
 public:
  DelayMemory(int longest, int order)
      : line_((longest + kMaxSubBlock) * Width, (kMaxSubBlock + order) * Width) {}

  void absorb(const NodeBlock& block) noexcept override {
    Contiguous<Width> x;
    line_.write(x(block.in[0], block.frames), block.frames * Width);
  }
  void adopt(const Node& before) noexcept override {
    if (const auto* other = dynamic_cast<const DelayMemory*>(&before)) line_.adopt(other->line_);
  }
  void reset() noexcept override {
    line_.reset();
    clamped_ = 0;
  }
  std::int64_t clamped() const override { return clamped_; }

 protected:
  DelayLine line_;
  std::int64_t clamped_ = 0;
};

/// Reads `Order` + 1 taps of one signal or of eight interleaved ones; order 0 is the nearest whole frame.
template <int Order, int Width = 1>
class DelayNode final : public DelayMemory<Width> {
 public:
  template <class T>
  using PerLane = std::array<T, static_cast<std::size_t>(Width)>;

  /// Clamped frames are counted in lanes that are `used`.
  DelayNode(const PerLane<tactus_delay>& ranges, const PerLane<bool>& used)
      : DelayMemory<Width>(range_of(ranges).most + Order, Order), ranges_(ranges), used_(used) {
    for (std::size_t lane = 0; lane < Width; ++lane) set_aim(lane, ranges_[lane].low);
  }

  void process(const NodeBlock& block) noexcept override {
    this->absorb(block);
    read(block, block.frames);
  }
  void emit(const NodeBlock& block) noexcept override { read(block, 0); }
  void copy(const Node& other) noexcept override { assign(*this, other); }

  DelayRange delay(int input, int) const override { return input == 0 ? range_of(ranges_) : DelayRange{}; }

  std::optional<std::complex<double>> response(int input, int, std::complex<double> z,
                                               std::span<const double> at) const override {
    if (input != 0) return std::nullopt;
    return delay_response<Order>(ranges_[0], tactus_delay_inside(&ranges_[0], at[kDelayTime]), z);
  }

  std::unique_ptr<Node> vectorised(std::span<const Node* const> lanes) const override {
    std::array<tactus_delay, kVectorWidth> ranges;
    std::array<bool, kVectorWidth> used{};
    for (std::size_t lane = 0; lane < kVectorWidth; ++lane) {
      used[lane] = lanes[lane] != nullptr;
      ranges[lane] = static_cast<const DelayNode*>(used[lane] ? lanes[lane] : this)->ranges_[0];
    }
    return std::make_unique<DelayNode<Order, kVectorWidth>>(ranges, used);
  }

 private:
  static DelayRange range_of(const PerLane<tactus_delay>& ranges) {
    DelayRange all{tactus_delay_least(&ranges[0], Order), 0};
    for (const auto& range : ranges)
      all = {std::min(all.least, tactus_delay_least(&range, Order)),
             std::max(all.most, tactus_delay_most(&range, Order))};
    return all;
  }

  void set_aim(std::size_t lane, double seconds) noexcept {
    double weights[Order + 1];
    aimed_at_[lane] = seconds;
    newest_[lane] = tactus_delay_aim(&ranges_[lane], Order, seconds, weights);
    for (std::size_t k = 0; k <= Order; ++k) weights_[k * Width + lane] = weights[k];
  }
  double inside(std::size_t lane, double wanted, int frames) noexcept {
    const double seconds = tactus_delay_inside(&ranges_[lane], wanted);
    if (seconds != wanted && used_[lane]) this->clamped_ += frames;
    return seconds;
  }
  void set_aims(const VectorSignal& time, int frame, int frames) noexcept {
    for (std::size_t lane = 0; lane < Width; ++lane) {
      const double seconds = inside(lane, time.lane(static_cast<int>(lane), frame), frames);
      if (seconds != aimed_at_[lane]) set_aim(lane, seconds);
    }
  }

  /// Also where a phase delay gives the same in every frame.
  static bool steady(const Signal& time, int frames) noexcept {
    if (time.constant() || Width > 1) return time.constant();
    return std::all_of(time.data, time.data + frames, [&](double t) { return t == time.data[0]; });
  }

  /// `written`: how many of the frames to come the line has got already.
  void read(const NodeBlock& block, int written) noexcept {
    const Signal time = block.in[kDelayTime];
    double* const y = block.out[0];
    if (steady(time, block.frames)) {
      set_aims(VectorSignal{time}, 0, block.frames);
      return read_steady(y, block.frames, written);
    }
    for (int n = 0; n < block.frames; ++n)
      if constexpr (Width == 1) {
        y[n] = tactus_delay_read(&ranges_[0], Order, line_.line(), written - n, inside(0, time[n], 1));
      } else {
        set_aims(VectorSignal{time}, n, 1);
        read_steady(y + n * Width, 1, written - n);
      }
  }

  void read_steady(double* y, int frames, int written) noexcept {
    const double* const newest = line_.tap(newest_[0] + written, Order);
    if constexpr (Width > 1)
      read_lanes(y, frames, written);
    else if constexpr (Order == 0)
      copy_samples(newest, frames, y);
    else
      tap_sums<Order + 1>(newest, weights_.data(), nullptr, y, frames);
  }

  void read_lanes(double* y, int frames, int written) noexcept {
    LanePlaces oldest;
    std::array<Lanes, Order + 1> weights;
    for (std::size_t lane = 0; lane < Width; ++lane)
      oldest[lane] = line_.tap((newest_[lane] + Order + written) * Width) + lane;
    for (std::size_t k = 0; k <= Order; ++k) weights[k] = Lanes::load(&weights_[k * Width]);
    VectorTaps<Order + 1> taps{oldest};
    for (int n = 0; n < frames; ++n, y += Width) {
      taps.next(oldest, n);
      (Order == 0 ? taps.newest() : taps.sum(weights, Lanes::broadcast(0))).store(y);
    }
  }

  using DelayMemory<Width>::line_;

  PerLane<tactus_delay> ranges_;
  PerLane<bool> used_;
  PerLane<double> aimed_at_{};
  PerLane<int> newest_{};
  alignas(64) std::array<double, static_cast<std::size_t>((Order + 1) * Width)> weights_{};
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

}  // namespace

Result<tactus_delay> delay_range(const NodeSetup& setup) {
  const auto min = time_of(setup, "min");
  if (!min) return tl::unexpected(min.error());
  const auto max = time_of(setup, "max");
  if (!max) return tl::unexpected(max.error());
  const double low = min->value_or(0), high = max->value_or(kUnlimited);
  if (low > high)
    return fail(Errc::OutOfRange, {}, "'min' of a delay is longer than its 'max'", "exchange them");
  const auto known = setup.input("time").range;
  const auto range = tactus_delay_between(std::clamp(known.low, low, high), std::clamp(known.high, low, high),
                                          setup.sample_rate.value);
  if (!std::isfinite(range.high))
    return fail(Errc::OutOfRange, {}, "the maximum delay cannot be determined", "give max = \"...\" a time");
  if (range.high * setup.sample_rate.value > kDelayMostFrames)
    return fail(Errc::OutOfRange, {},
                "it can be " + std::to_string(std::llround(std::min(range.high, 1e15))) +
                    " s long, but the longest possible delay is " +
                    std::to_string(std::llround(kDelayMostFrames / setup.sample_rate.value)) + " s",
                "shorten 'time', or give 'max'");
  return range;
}

int delay_order(const NodeSetup& setup) {
  const auto& word = setup.setting("interpolation").text;
  return word == "none" ? 0 : word == "linear" ? 1 : word == "lagrange5" ? 5 : 3;
}

namespace {

template <int Order>
Result<std::unique_ptr<Node>> delay_of(const tactus_delay& range) {
  return std::make_unique<DelayNode<Order>>(std::array{range}, std::array{true});
}

Result<std::unique_ptr<Node>> make_delay(const NodeSetup& setup) {
  const auto range = delay_range(setup);
  if (!range) return tl::unexpected(range.error());
  const auto frames = static_cast<std::size_t>(std::ceil(range->high * setup.sample_rate.value));
  if (const auto fits = setup.take_memory(frames); !fits) return tl::unexpected(fits.error());
  switch (delay_order(setup)) {
    case 0:
      return delay_of<0>(*range);
    case 1:
      return delay_of<1>(*range);
    case 5:
      return delay_of<5>(*range);
    default:
      return delay_of<3>(*range);
  }
}

}  // namespace

NodeType delay_type() {
  return {
      .name = "delay",
      .summary = "Delays a signal. It may close a loop, and its time may change from frame to frame.",
      .equation =
          "out[n] = in(n - time fs), between frames the polynomial through 2, 4 or 6 of them.\n"
          "Below 1 frame (linear), 2 (lagrange3) or 3 (lagrange5) the polynomial is evaluated outside its "
          "middle interval, because later frames do not exist yet: high frequencies are then less exact and "
          "amplified by up to a few dB.\n"
          "Least delay = floor(shortest time fs) less 1 for lagrange3, 2 for lagrange5; at least 1 where the "
          "time is never below a frame",
      .source = "Laakso, Valimaki, Karjalainen & Laine, IEEE SP Magazine 13, 1996",
      .example = "{ type = \"delay\", in = \"string\", time = \"20 ms\" }",
      .inputs = {late({"in", "any", "signal to delay"}), {"time", "s", "delay time", {}, 0}},
      .outputs = {{"out", "=in", "the input, delayed by `time`"}},
      .silencers = {{"in"}},
      .settings =
          {choice("interpolation",
                  "interpolation between frames; none: rounds to whole frames. Error below 0.1 dB: linear up "
                  "to fs/21, lagrange3 up to fs/8 (its taps begin one frame earlier), lagrange5 up to fs/6 "
                  "(two frames earlier)",
                  {"none", "linear", "lagrange3", "lagrange5"}, "lagrange3"),
           {"min", Setting::Kind::Text, "minimum delay time, if the graph does not determine it"},
           {"max", Setting::Kind::Text, "maximum delay time, if the graph does not determine it"},
           {"compensate", Setting::Kind::Names,
            "filters in the same loop; their phase delays at the frequency 1/time are subtracted "
            "from the time, so that the loop is in tune"}},
      .make = make_delay,
      .compensation = PhaseCompensation{.port = kDelayTime, .period = kDelayTime, .sign = -1}};
}

}  // namespace tactus
