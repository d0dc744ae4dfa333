#include "engine/dsp/envelopes/onset.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/core/decibels.h"

namespace tactus {
namespace {

// Found on the training half of the recordings of docs/onset_study.md. Times in groups, which are
// milliseconds.
constexpr double kGroup_s = 0.001, kMean_s = 0.004;
constexpr double kRinging =
    28;                     // for which the times below were found; less than an interval of 30 hits a second
constexpr int kNewest = 5;  // what it leaves out
constexpr int kNewestLow = 2;  // so much more in band 0, where a cycle is long
constexpr double kMaskStays = 10;
constexpr int kFloorHeld = 100;
constexpr int kFloorStart = 10;
constexpr double kBlocked[4] = {0, 20, 45, 60};
constexpr double kLowest_hz = 30;
constexpr double kCutoff_hz[4] = {0, 400, 2000, 7000};
constexpr double kFall_s[4] = {0.020, 0.001, 0.001, 0.001};
constexpr Four kThreshold = {0.89, 0.22, 0.089, 0.071};  // -1, -13, -21, -23 dB
constexpr Four kRingMargin = {1.06, 1.06, 1, 1};         // the fundamentals of a drum beat most
constexpr double kSoftMargin = 1.41;                     // +3 dB
constexpr double kMaskSpeed[4] = {0.15, 1, 1, 1};        // a fundamental rings near its peak for long
constexpr double kSoft = 0.63;                           // -4 dB
constexpr double kRingFall = 0.986279;                   // -0.12 dB a group
constexpr double kFloorRise_db_per_s = 20;
constexpr Four kLeastFloor = {1e-5, 1e-5, 1e-5,
                              1e-5};  // after digital silence the floor must find its way up

}  // namespace

OnsetDetector::OnsetDetector(const Settings& settings) : sample_rate_(settings.sample_rate.value) {
  const double rate = sample_rate_;
  const double ringing = std::clamp(settings.ringing.value / kGroup_s, 8.0, kPast - 1.0);
  window_ = static_cast<int>(std::lround(ringing));
  mask_stays_ = static_cast<int>(std::lround(kMaskStays * ringing / kRinging));
  group_frames_ = std::max(1, static_cast<int>(std::lround(kGroup_s * rate)));
  const double group_s = group_frames_ / rate;
  for (int b = 0; b < 4; ++b) {
    const double cutoff = b > 0 ? std::max(kCutoff_hz[b], settings.high_pass.value) : kLowest_hz;
    blocked_[b] = b > 0 || settings.high_pass.value <= kLowest_hz ? kBlocked[b] * ringing / kRinging
                                                                  : std::numeric_limits<double>::infinity();
    feedback_[b] = 1 / (1 + 2 * std::numbers::pi * cutoff / rate);
    fast_fall_[b] = std::exp(-1 / (rate * kFall_s[b]));
  }
  mean_rise_ = 1 - std::exp(-1 / (rate * kMean_s));
  for (int b = 0; b < 4; ++b)
    mask_fall_[b] = amplitude_from_db(-20 * group_s * kMaskSpeed[b] / settings.mask_time.value);
  floor_rise_ = amplitude_from_db(kFloorRise_db_per_s * group_s);
}

Four OnsetDetector::ringing(const State& state) const noexcept {
  const auto past = [&](int groups) {
    return state.past_[static_cast<std::size_t>((state.slot_ - groups) & (kPast - 1))];
  };
  Four ring{}, ring_low{};
  for (int k = window_ - 1; k >= kNewest; --k) {
    ring = max(ring * kRingFall, past(k));
    if (k == kNewest + kNewestLow) ring_low = ring;
  }
  for (int k = 0; k < kNewestLow; ++k) ring_low *= kRingFall;
  ring[0] = ring_low[0];
  return ring;
}

// What began in the hold belongs to the hit, also where the bars are older than that.
void OnsetDetector::end_hold(State& state, const Sensitivity& sensitivity) const noexcept {
  state.mask_ = state.last_ = max(state.last_, state.group_);
  state.groups_free_ = 0;
  state.bar_ = max(state.bar_, state.mask_ * sensitivity.margin);
}

void OnsetDetector::close_group(State& state, const Sensitivity& sensitivity) const noexcept {
  state.frame_ = 0;
  state.slot_ = (state.slot_ + 1) & (kPast - 1);
  state.past_[static_cast<std::size_t>(state.slot_)] = state.group_;
  if (state.hold_ > 0) state.mask_ = state.last_ = max(state.last_, state.group_);
  if (state.groups_free_ >= mask_stays_) state.mask_ *= mask_fall_;
  if (state.groups_since_ > kFloorHeld) state.floor_ *= floor_rise_;
  state.floor_ = state.groups_ < kFloorStart ? state.mean_ : min(state.mean_, state.floor_);
  state.floor_ = max(state.floor_, kLeastFloor);
  const Four ring = ringing(state) * kRingMargin * sensitivity.margin;
  const Four stroke = max(ring, min(ring * kSoftMargin, state.last_ * kSoft));
  state.bar_ = max(max(stroke, state.mask_ * sensitivity.margin),
                   max(state.floor_ * sensitivity.noise_margin, kThreshold * sensitivity.threshold));
  for (int b = 0; b < 4; ++b)
    if (state.groups_since_ < blocked_[b]) state.bar_[b] = std::numeric_limits<double>::infinity();
  state.group_ = state.fast_;
  state.groups_since_ = std::min(state.groups_since_ + 1, kLongAgo);
  state.groups_free_ = state.hold_ > 0 ? 0 : std::min(state.groups_free_ + 1, kLongAgo);
  state.groups_ = std::min(state.groups_ + 1, kLongAgo);
}

}  // namespace tactus
