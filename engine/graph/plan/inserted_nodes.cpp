#include "engine/graph/plan/inserted_nodes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/core/transpose.h"
#include "engine/dsp/kernel.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/semantics/lane_operators.h"

namespace tactus {
namespace {

using Row = std::array<double, kVectorWidth>;

/// The lanes of one frame of an input, whatever its stride.
template <bool kSame>
double lane_of(const double* frame, int lane) noexcept {
  return frame[kSame ? 0 : lane];
}

template <Expression::Op kOp, bool kSameLeft, bool kSameRight>
void run(const Signal* in, double* out, int frames) noexcept {
  constexpr auto value = operator_of(kOp).value;
  const double* left = in[0].data;
  const double* right = in[1].data;
  const auto left_stride = in[0].stride, right_stride = in[1].stride;
  for (int n = 0; n < frames; ++n, out += kVectorWidth) {
    if constexpr (kHasLanes<kOp>) {
      lanes_of<kOp>(operand_lanes(left, kSameLeft), operand_lanes(right, kSameRight)).store(out);
    } else {
      Row result;
      for (int lane = 0; lane < kVectorWidth; ++lane)
        result[index(lane)] = value(lane_of<kSameLeft>(left, lane), lane_of<kSameRight>(right, lane), 0);
      std::copy_n(result.data(), kVectorWidth, out);
    }
    left += left_stride;
    right += right_stride;
  }
}

template <Expression::Op kOp>
void run_two(const Signal* in, double* out, int frames) noexcept {
  const bool same_left = in[0].stride == 1, same_right = in[1].stride == 1;
  if (same_left && same_right) return run<kOp, true, true>(in, out, frames);
  if (same_left) return run<kOp, true, false>(in, out, frames);
  if (same_right) return run<kOp, false, true>(in, out, frames);
  return run<kOp, false, false>(in, out, frames);
}

template <Expression::Op kOp>
void run_three(const Signal* in, double* out, int frames) noexcept {
  constexpr auto value = operator_of(kOp).value;
  const auto at = [in](int operand, int n, int lane) {
    const auto& signal = in[operand];
    return signal.data[n * signal.stride + (signal.stride == 1 ? 0 : lane)];
  };
  for (int n = 0; n < frames; ++n)
    for (int lane = 0; lane < kVectorWidth; ++lane)
      *out++ = value(at(0, n, lane), at(1, n, lane), at(2, n, lane));
}

/// Of one operand.
template <Expression::Op kOp>
void run_one(const Signal* in, double* out, int frames) noexcept {
  const Signal twice[2] = {in[0], in[0]};
  return in[0].stride == 1 ? run<kOp, true, true>(twice, out, frames)
                           : run<kOp, false, false>(twice, out, frames);
}

using Run = void (*)(const Signal* in, double* out, int frames) noexcept;

template <std::size_t kEntry>
constexpr Run run_of() {
  constexpr auto& type = kOperators[kEntry];
  if constexpr (type.value == nullptr)
    return nullptr;
  else if constexpr (type.operands == 1)
    return run_one<type.op>;
  else if constexpr (type.operands == 2)
    return run_two<type.op>;
  else
    return run_three<type.op>;
}

/// A loop of its own for each operator.
constexpr auto kRuns = []<std::size_t... kEntries>(std::index_sequence<kEntries...>) {
  return std::array<Run, sizeof...(kEntries)>{run_of<kEntries>()...};
}
(std::make_index_sequence<kOperators.size()>{});

}  // namespace

std::optional<double> PhaseDelay::phase_delay(double tuned) const noexcept {
  if (!(tuned > 0)) return std::nullopt;
  const double frequency = 1 / tuned;
  const auto response = other_->response(0, 0, on_circle(Hertz{frequency}, sample_rate_), values_);
  if (!response) return std::nullopt;
  return -std::arg(*response) / (2 * std::numbers::pi * frequency);
}

void PhaseDelay::process(const NodeBlock& block) noexcept {
  for (int frame = 0; frame < block.frames; ++frame) {
    bool changed = !known_ || block.in[1][frame] != tuned_;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const double now = block.in[i + 2][frame];
      changed |= now != values_[i];
      values_[i] = now;
    }
    if (changed) {
      tuned_ = block.in[1][frame];
      result_ = phase_delay(tuned_).value_or(0);
      known_ = true;
    }
    block.out[0][frame] = block.in[0][frame] + sign_ * result_;
  }
}

std::optional<double> PhaseDelay::at(const std::shared_ptr<const Node>& other, double tuned,
                                     const std::vector<double>& inputs, Hertz sample_rate) {
  PhaseDelay probe{other, static_cast<int>(inputs.size()), sample_rate, 1};
  probe.values_ = inputs;
  return probe.phase_delay(tuned);
}

std::optional<Interval> PhaseDelay::range(const std::shared_ptr<const Node>& other, Interval tuned,
                                          const std::vector<Interval>& inputs, Hertz sample_rate) {
  PhaseDelay probe{other, static_cast<int>(inputs.size()), sample_rate, 1};
  std::optional<Interval> found;
  constexpr int kSteps = 64;
  const std::size_t corners = std::size_t{1} << std::min<std::size_t>(inputs.size(), 8);
  for (std::size_t corner = 0; corner < corners; ++corner) {
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      const auto& range = inputs[i];
      const double end = (corner >> i & 1) != 0 ? range.high : range.low;
      probe.values_[i] = std::isfinite(end) ? end : 0;
    }
    for (int step = 0; step <= kSteps; ++step) {
      const double time = tuned.low * std::pow(tuned.high / tuned.low, static_cast<double>(step) / kSteps);
      const auto delay = probe.phase_delay(time);
      if (!delay) continue;
      const auto here = Interval::exactly(*delay);
      found = found.value_or(here).joined(here);
    }
  }
  return found;
}

using How = RateConversion::How;

RateConverter::RateConverter(const RateConversion& how, int divisor, Hertz fast_rate)
    : how_(how.how),
      into_(divisor > how.from),
      ratio_(into_ ? divisor / how.from : how.from / divisor),
      fast_rate_(fast_rate) {}

int RateConverter::runs_every(const RateConversion& how, int divisor) {
  const bool into = divisor > how.from;
  return into && how.how == How::Last ? divisor : std::min(divisor, how.from);
}

void RateConverter::reset() noexcept {
  gathered_ = before_ = latest_ = 0;
  started_ = false;
}

void RateConverter::process(const NodeBlock& block) noexcept {
  if (!into_) return give(block);
  if (how_ != How::Last) return take(block);
  for (int m = 0; m < block.frames; ++m) block.out[0][m] = block.in[0][m];
}

void RateConverter::take(const NodeBlock& block) noexcept {
  double* out = block.out[0];
  auto position = block.first_frame % ratio_;
  for (int n = 0; n < block.frames; ++n) {
    const double in = block.in[0][n];
    // Shares of a mean are added up, not samples: those may be so large that their sum is none.
    gathered_ = how_ == How::Trigger ? std::max(gathered_, in) : gathered_ + in / ratio_;
    if (position == 0) {
      *out++ = started_ ? gathered_ : in;
      started_ = true;
      gathered_ = 0;
    }
    position = position + 1 == ratio_ ? 0 : position + 1;
  }
}

void RateConverter::give(const NodeBlock& block) noexcept {
  auto position = block.first_frame % ratio_;
  for (int n = 0, m = 0; n < block.frames; ++n) {
    if (position == 0) {
      const double in = block.in[0][m++];
      before_ = started_ ? latest_ : in;
      latest_ = in;
      started_ = true;
    }
    block.out[0][n] = between(position);
    position = position + 1 == ratio_ ? 0 : position + 1;
  }
}

double RateConverter::between(std::int64_t position) const noexcept {
  if (how_ == How::Last) return latest_;
  if (how_ == How::Trigger) return position == 0 ? latest_ : 0.0;
  const double part = static_cast<double>(position) / ratio_;
  return (1 - part) * before_ + part * latest_;
}

DelayRange RateConverter::delay(int, int) const {
  if (into_) return {0, how_ == How::Last ? 0 : ratio_ - 1};
  return {0, how_ == How::Smooth ? ratio_ : ratio_ - 1};
}

std::optional<std::complex<double>> RateConverter::response(int, int, std::complex<double> z,
                                                            std::span<const double>) const {
  if (how_ == How::Trigger) return std::nullopt;
  if (into_ && how_ == How::Last) return 1.0;
  std::complex<double> mean = 0, power = 1;
  for (int j = 0; j < ratio_; ++j, power /= z) mean += power / static_cast<double>(ratio_);
  return into_ || how_ == How::Last ? mean : mean * mean / z;
}

std::string RateConverter::about() const {
  const auto frames = std::to_string(ratio_) + " frames";
  const auto late = [&](double of_frames) {
    return short_quantity(of_frames / fast_rate_.value, parse_unit("s")->dimension) + " late";
  };
  const double half = 0.5 * (ratio_ - 1);
  if (into_) {
    const auto rate = short_quantity(fast_rate_.value / ratio_, parse_unit("Hz")->dimension);
    if (how_ == How::Last) return "is sampled once per " + frames + ", at " + rate;
    if (how_ == How::Trigger) return "triggers once in " + frames + " at most, at " + rate;
    return "is the mean over " + frames + ", at " + rate + ": " + late(half);
  }
  if (how_ == How::Last) return "is held for " + frames + ": on average " + late(half);
  if (how_ == How::Trigger) return "triggers in the first of " + frames;
  return "is interpolated linearly over " + frames + ": " + late(ratio_);
}

void VectorOperation::process(const NodeBlock& block) noexcept {
  kRuns[entry_of(op_)](block.in, block.out[0], block.frames);
}

void Pack::process(const NodeBlock& block) noexcept {
  double* out = block.out[0];
  if (std::all_of(block.in, block.in + kVectorWidth, [](const Signal& lane) { return lane.stride == 1; })) {
    std::array<const double*, kVectorWidth> rows;
    for (std::size_t lane = 0; lane < kVectorWidth; ++lane) rows[lane] = block.in[lane].data;
    return Transpose::pack(rows, out, block.frames);
  }
  for (int n = 0; n < block.frames; ++n)
    for (int lane = 0; lane < kVectorWidth; ++lane) *out++ = block.in[lane][n];
}

void LaneSum::process(const NodeBlock& block) noexcept {
  const int whole = lanes_ / kVectorWidth, rest = lanes_ % kVectorWidth, all = block.frames * kVectorWidth;
  // A sum begins at -0: x + -0 = x for every x, also for -0.
  if (whole == 0) std::fill_n(sums_.begin(), all, -0.0);
  if (whole > 0) std::copy_n(block.in[0].data, all, sums_.begin());
  for (int i = 1; i < whole; ++i) {
    const double* const rows = block.in[i].data;
    for (int k = 0; k < all; ++k) sums_[index(k)] += rows[k];
  }
  double* sum = sums_.data();
  for (int n = 0; n < block.frames; ++n, sum += kVectorWidth) {
    for (int lane = 0; lane < rest; ++lane) sum[lane] += block.in[whole].data[n * kVectorWidth + lane];
    block.out[0][n] = tactus_sum_of_eight(sum);
  }
}

}  // namespace tactus
