#include "engine/dsp/strings/string_loop.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/dsp/delays/taps.h"

namespace tactus {
namespace {

/// Into [low, high]; NaN becomes `low`.
double clamped(double x, double low, double high) { return x > low ? std::min(x, high) : low; }

std::complex<double> polynomial(const double* coefficients, int count, std::complex<double> x) {
  std::complex<double> sum = 0;
  while (count-- > 0) sum = sum * x + coefficients[count];
  return sum;
}

}  // namespace

StringDesign::StringDesign(StringParameters p, LossFilter filter, Hertz sample_rate, double most_gain,
                           double frames_outside) {
  const bool zero = filter == LossFilter::OneZero;
  const double frequency = clamped(p.pitch_hz, StringLoop::kLowestPitch, 0.3 * sample_rate.value);
  const double gain = clamped(p.gain, 0, most_gain);
  const double loss = clamped(p.loss, 0, zero ? 1 : 0.99);
  const double radians = 2 * std::numbers::pi * frequency / sample_rate.value;
  const auto delay = std::polar(1.0, -radians);

  const std::array<double, 2> zeros = zero ? std::array{1 - loss / 2, loss / 2} : std::array{1 - loss, 0.0};
  pole = zero ? 0 : loss;
  const auto filter_response = polynomial(zeros.data(), 2, delay) / (1.0 - pole * delay);

  // The middle interval of six taps starts two frames behind the newest, which itself must be in the past.
  const double frames =
      std::max(3.0, sample_rate.value / frequency + std::arg(filter_response) / radians - frames_outside);
  newest = static_cast<int>(frames) - 2;
  const double wanted = frames - newest;
  auto weights = lagrange_weights<5>(wanted);
  const double ahead =
      std::arg(polynomial(weights.data(), 6, delay) * std::polar(1.0, radians * wanted)) / radians;
  weights = lagrange_weights<5>(wanted + ahead);

  for (std::size_t k = 0; k < weights.size(); ++k) {
    taps[k] += gain * zeros[0] * weights[k];
    taps[k + 1] += gain * zeros[1] * weights[k];
  }
}

std::complex<double> StringDesign::loop(std::complex<double> delay) const {
  return std::pow(delay, newest) * polynomial(taps.data(), kTaps, delay) / (1.0 - pole * delay);
}

int StringLoop::longest_delay(Hertz sample_rate, double lowest_pitch) {
  return static_cast<int>(sample_rate.value / std::max(kLowestPitch, lowest_pitch)) + StringDesign::kTaps;
}

DesignedLine::DesignedLine(LossFilter filter, int longest)
    : filter_(filter), line_(longest, kMostFrames + StringDesign::kTaps) {}

bool DesignedLine::changed(const StringParameters& parameters) noexcept {
  if (parameters == parameters_) return false;
  parameters_ = parameters;
  return true;
}

void DesignedLine::set(const StringDesign& design) noexcept {
  design_ = design;
  losses_.design({design.pole});
}

const double* DesignedLine::newest_tap(int written) const noexcept {
  constexpr int kOlder = StringDesign::kTaps - 1;
  return line_.behind(design_.newest + kOlder + written) + kOlder;
}

void DesignedLine::reset() noexcept {
  line_.reset();
  losses_.reset();
}

void DesignedLine::adopt(DesignedLine& other) noexcept {
  line_.adopt(other.line_);
  if (filter_ == other.filter_) losses_.adopt(other.losses_);
}

StringLoop::StringLoop(LossFilter filter, Hertz sample_rate, double lowest_pitch)
    : DesignedLine(filter, longest_delay(sample_rate, lowest_pitch)), sample_rate_(sample_rate) {
  set({parameters_, filter, sample_rate});
}

void StringLoop::tune(const StringParameters& parameters, int /*lane*/) noexcept {
  if (changed(parameters)) set({parameters, filter_, sample_rate_});
}

/// As long as the newest tap lies before it, and ending with a group where that is possible: a cut group
/// costs nearly as much as a whole one.
int StringLoop::sub_block(int frames, int position) const noexcept {
  const int most = std::min(kMostFrames, design_.newest);
  if (frames <= most) return frames;
  const int whole = most - (position + most) % kGroup;
  return whole > 0 ? whole : most;
}

double StringLoop::run_single(double x, int position) noexcept {
  const double* newest = newest_tap();
  const double y = filter_ == LossFilter::OneZero
                       ? tap_sum(newest, design_.taps, x)
                       : x + losses_.run_single(tap_sum(newest, design_.taps, 0), position);
  line_.write(&y, 1);
  return y;
}

void StringLoop::run(const double* x, double* y, int frames, int position) noexcept {
  while (frames > 0) {
    const int count = sub_block(frames, position);
    const double* newest = newest_tap();
    if (filter_ == LossFilter::OneZero) {
      tap_sums(newest, design_.taps, x, y, count);
    } else {
      std::array<double, kMostFrames> around;
      tap_sums(newest, design_.taps, nullptr, around.data(), count);
      losses_.run(around.data(), around.data(), count, position);
      for (int n = 0; n < count; ++n) y[n] = x[n] + around[static_cast<std::size_t>(n)];
    }
    line_.write(y, count);
    x += count, y += count, frames -= count;
    position = (position + count) % kGroup;
  }
}

VectorStringLoop::VectorStringLoop(LossFilter filter, Hertz sample_rate, double lowest_pitch)
    : filter_(filter),
      sample_rate_(sample_rate),
      line_(StringLoop::longest_delay(sample_rate, lowest_pitch) * Lanes::kCount,
            (kMostFrames + StringDesign::kTaps) * Lanes::kCount) {
  const StringDesign design{{}, filter, sample_rate};
  for (int lane = 0; lane < Lanes::kCount; ++lane) take(lane, design);
}

void VectorStringLoop::tune(const StringParameters& parameters, int lane) noexcept {
  auto& before = parameters_[static_cast<std::size_t>(lane)];
  if (parameters == before) return;
  before = parameters;
  take(lane, StringDesign{parameters, filter_, sample_rate_});
}

void VectorStringLoop::take(int lane, const StringDesign& design) noexcept {
  const auto l = static_cast<std::size_t>(lane);
  newest_[l] = design.newest;
  pole_[l] = design.pole;
  for (std::size_t k = 0; k < kTaps; ++k) weights_[k][l] = design.taps[k];
  shortest_ = *std::min_element(newest_.begin(), newest_.end());
}

void VectorStringLoop::reset() noexcept {
  line_.reset();
  loss_.fill(0.0);
}

}  // namespace tactus
