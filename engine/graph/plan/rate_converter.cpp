#include "engine/graph/plan/rate_converter.h"

#include <algorithm>

#include "engine/graph/file/quantity.h"

namespace tactus {

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
    if (how_ == How::Last) return "is taken once in " + frames + ", at " + rate;
    if (how_ == How::Trigger) return "fires once in " + frames + " at most, at " + rate;
    return "is the mean of " + frames + ", at " + rate + ": " + late(half);
  }
  if (how_ == How::Last) return "is held for " + frames + ": on average " + late(half);
  if (how_ == How::Trigger) return "fires in the first of " + frames;
  return "goes straight to its next value in " + frames + ": " + late(ratio_);
}

}  // namespace tactus
