#include "backends/loop/loop_path.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "engine/dsp/curves/curve_kernel.h"
#include "engine/dsp/envelopes/envelope_kernel.h"

namespace tactus {
namespace {

constexpr double kAgcPeak = 0.1, kAgcMostGain = 100.0;
constexpr Seconds kAgcAttack{0.002}, kAgcRelease{0.5};
constexpr Seconds kFurthest{2.0};  // that the delay may grow

constexpr std::size_t kTaps = 2 * SincLine::kReach;
constexpr double kWidth = 9.0;  // standard deviation of the Gaussian [frames]
// Between phases the kernel is taken as straight: wrong by (pi / phases)^2 / 8, which is 1e-6.
constexpr int kPhases = 1024;

using Taps = std::array<double, kTaps>;

/// Weights of the frames -kReach + 1 … kReach around `fraction`.
Taps taps_at(double fraction) {
  Taps taps{};
  for (std::size_t k = 0; k < kTaps; ++k) {
    const double u = static_cast<double>(k) - SincLine::kReach + 1 - fraction;
    const double x = std::numbers::pi * u;
    taps[k] = (u == 0.0 ? 1.0 : std::sin(x) / x) * std::exp(-0.5 * (u / kWidth) * (u / kWidth));
  }
  return taps;
}

const std::vector<Taps>& table() {
  static const std::vector<Taps> phases = [] {
    std::vector<Taps> all;
    for (int phase = 0; phase <= kPhases; ++phase)
      all.push_back(taps_at(static_cast<double>(phase) / kPhases));
    return all;
  }();
  return phases;
}

void set_taps(double fraction, Taps& taps) noexcept {
  const double position = fraction * kPhases;
  const auto phase = static_cast<std::size_t>(position);
  const double share = position - static_cast<double>(phase);
  const Taps& below = table()[phase];
  const Taps& above = table()[phase + 1];
  for (std::size_t k = 0; k < kTaps; ++k) taps[k] = below[k] + share * (above[k] - below[k]);
}

/// 1 - H of the low-pass.
tactus_filter_design high_pass(double radians) {
  const auto low = tactus_one_pole(radians);
  return tactus_filter_order_1(1.0 - low.b[0], -low.a[0] - low.b[1], low.a[0]);
}

std::int64_t line_frames(const LoopTiming& timing) {
  return static_cast<std::int64_t>(timing.hardware_frames + frames_in(kFurthest, timing.sample_rate)) +
         timing.buffer_frames + 2 * timing.block_frames;
}

}  // namespace

SincLine::SincLine(std::int64_t back)
    : samples_(std::bit_ceil(static_cast<std::size_t>(back + 2 * kTaps))), mask_(samples_.size() - 1) {
  (void)table();  // made here and not on the real-time path
}

double SincLine::read(std::int64_t frame, double fraction) noexcept {
  if (fraction == 0.0) return (*this)[frame];
  if (fraction != fraction_) {
    fraction_ = fraction;
    set_taps(fraction, taps_);
  }
  std::array<double, 4> sums{};  // one would wait for each addition
  for (std::size_t k = 0; k < kTaps; k += 4)
    for (std::size_t i = 0; i < 4; ++i)
      sums[i] += taps_[k + i] * (*this)[frame + static_cast<std::int64_t>(k + i) - kReach + 1];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

LoopPath::LoopPath(const LoopCard& card, const LoopTiming& timing, int lane)
    : card_(card),
      timing_(timing),
      line_(line_frames(timing)),
      captured_(timing.buffer_frames),
      noise_(1, static_cast<std::uint64_t>(lane)),
      attack_keep_(tactus_keep(kAgcAttack.value, timing.sample_rate.value)),
      release_keep_(tactus_keep(kAgcRelease.value, timing.sample_rate.value)),
      step_(card.bits > 0 ? std::ldexp(1.0, 1 - card.bits) : 0.0),
      monitor_frames_(card.monitor_in_software ? 1 + timing.buffer_frames : 1) {
  if (card.high_pass.value > 0.0)
    high_pass_.emplace().design(
        high_pass(tactus_filter_radians(card.high_pass.value, timing.sample_rate.value)));
  if (card.echo_cancel) canceller_.emplace();
}

double LoopPath::record(std::int64_t frame, double later) noexcept {
  if (card_.monitor_gain != 0.0) {
    line_.add(frame, card_.monitor_gain * captured_[frame - monitor_frames_]);
    played_ = true;
  }
  const double at = static_cast<double>(frame) - timing_.hardware_frames - later;
  const auto whole = static_cast<std::int64_t>(std::floor(at));
  double sample = played_ ? card_.gain * line_.read(whole, at - static_cast<double>(whole)) : 0.0;
  if (high_pass_) sample = high_pass_->run_single(sample, group_position(frame));
  sample += card_.dc;
  if (card_.noise > 0.0) sample += card_.noise * noise_.gaussian(frame);
  if (card_.agc) sample = controlled(sample);
  sample = converted(std::clamp(sample, -card_.clip, card_.clip));
  captured_.forget(frame);
  captured_.add(frame, sample);
  if (canceller_) sample = canceller_->step(line_, whole + EchoCanceller::kAhead, sample);
  line_.forget(frame + timing_.buffer_frames + 2 * timing_.block_frames);
  return sample;
}

void LoopPath::play(std::int64_t frame, double sample) noexcept {
  line_.add(frame + timing_.buffer_frames, converted(sample));
  played_ = true;
}

double LoopPath::converted(double sample) const noexcept {
  return std::clamp(tactus_quantise_nearest(sample, step_), -1.0, 1.0);
}

double LoopPath::controlled(double sample) noexcept {
  const double level = tactus_follower_step(&level_, sample, attack_keep_, release_keep_);
  return sample * std::min(kAgcMostGain, kAgcPeak / std::max(level, 1e-9));
}

}  // namespace tactus
