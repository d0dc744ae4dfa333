#include "engine/guard/drive_guard.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/core/every_block.h"
#include "engine/core/index.h"
#include "engine/dsp/simd/lanes.h"

namespace tactus {
namespace {

constexpr auto kRelaxed = std::memory_order_relaxed;

std::int64_t whole_frames(Seconds time, Hertz sample_rate) {
  return std::llround(frames_in(time, sample_rate));
}

/// Within the ceiling and no steeper than `step`, where it begins at `last`; a NaN is not. Rounded as
/// `within` rounds, so that both agree on what passes.
bool is_within(double sample, double last, double ceiling, double step) noexcept {
  return std::abs(sample) <= ceiling && sample >= last - step && sample <= last + step;
}

/// Whether each of many is. The last eight are read together, some of them for the second time.
bool all_within(const double* samples, int frames, double last, double ceiling, double step) noexcept {
  constexpr int kFew = Lanes::kCount, kAll = (1 << kFew) - 1;
  bool within = is_within(samples[0], last, ceiling, step);
  if (frames <= kFew) {
    for (int n = 1; n < frames; ++n) within = within && is_within(samples[n], samples[n - 1], ceiling, step);
    return within;
  }
  const auto high = Lanes::broadcast(ceiling), low = -high, steepest = Lanes::broadcast(step);
  int bits = kAll;
  for (int n = 1; n < frames; n += kFew) {
    const double* const here = samples + std::min(n, frames - kFew);
    const auto x = Lanes::load(here), before = Lanes::load(here - 1);
    bits &= at_least(high, x) & at_least(x, low) & at_least(x, before - steepest) &
            at_least(before + steepest, x);
  }
  return within && bits == kAll;
}

double sum_of_absolutes(const double* samples, int frames) noexcept {
  GroupSum sum;
  sum.add(0, frames, [=](int n) { return std::abs(samples[n]); });
  return sum.take();
}

}  // namespace

DriveGuard::DriveGuard(Kind kind, const DriveLimits& limits, Hertz sample_rate, FeedbackPath path)
    : kind_(kind),
      ceiling_(limits.ceiling),
      largest_step_(kind == Kind::Drive ? limits.slew_per_second / sample_rate.value
                                        : std::numeric_limits<double>::infinity()),
      rise_frames_(whole_frames(limits.soft_start, sample_rate)),
      fall_frames_(whole_frames(limits.fade_out, sample_rate)),
      crest_frames_(whole_frames(kCrest, sample_rate)),
      swing_frames_(1 + static_cast<std::int64_t>(
                            std::min(static_cast<double>(crest_frames_), 4.0 * ceiling_ / largest_step_))),
      dc_(kind == Kind::Drive ? limits.dc : DcLimits{}, sample_rate),
      feedback_(path, sample_rate, limits.ceiling) {
  if (kind != Kind::Drive) return;
  if (limits.heat) heat_.emplace(*limits.heat, ceiling_, limits.slew_per_second, sample_rate);
  if (limits.excursion) excursion_.emplace(*limits.excursion, largest_step_, sample_rate);
}

void DriveGuard::set_open(bool open, std::int64_t frame) noexcept {
  if (open == is_open()) return;
  if (open) feedback_.forget();
  gain_.move_to(open ? 1.0 : 0.0, frame, open ? rise_frames_ : fall_frames_);
}

bool DriveGuard::stop(double* samples, int frames) noexcept {
  gain_ = {};
  for (int n = 0; n < frames; ++n)
    samples[n] = last_ = std::clamp(0.0, last_ - largest_step_, last_ + largest_step_);
  last_allowed_ = last_;
  feedback_.forget();
  return last_ == 0.0;
}

std::optional<std::int64_t> DriveGuard::take_feedback() noexcept {
  const auto frame = feedback_frame_;
  feedback_frame_.reset();
  return frame;
}

TACTUS_EVERY_BLOCK void DriveGuard::process(double* samples, int frames, std::int64_t first_frame) noexcept {
  while (frames > 0) {
    const int position = guard_position(first_frame);
    const int length = std::min(frames, kGuardGroup - position);
    const double sum = excursion_ ? sum_of_absolutes(samples, length) : 0.0;
    if (passes(samples, length, first_frame, sum)) {
      dc_.observe(samples, length, position);
      last_ = last_allowed_ = samples[length - 1];
      if (excursion_) excursion_->observe(samples, length, position, sum);
    } else {
      std::array<double, kGuardGroup> wanted;
      for (int n = 0; n < length; ++n)
        samples[n] = shape(samples[n], wanted[index(n)], first_frame + n, position + n);
      dc_.observe(wanted.data(), samples, length, position);
      if (excursion_) excursion_->observe(samples, length, position, sum_of_absolutes(samples, length));
    }
    if (heat_) heat_->observe(samples, length, position);
    samples += length;
    frames -= length;
    first_frame += length;
    if (position + length == kGuardGroup) end_group(first_frame);
  }
}

/// True if no stage can have anything to do in this block.
TACTUS_EVERY_BLOCK bool DriveGuard::passes(const double* samples, int frames, std::int64_t first_frame,
                                           double sum_of_absolutes) const noexcept {
  if (!gain_.done(first_frame) || gain_.to != 1.0 || feedback_.probing()) return false;
  if (!dc_.gain().idle() || (heat_ && !heat_->gain().idle())) return false;
  if (!all_within(samples, frames, last_, ceiling_, largest_step_)) return false;
  return !excursion_ || excursion_->stays_within(sum_of_absolutes, ceiling_);
}

/// One frame through all stages; `wanted`: what it is before the DC gain.
TACTUS_EVERY_BLOCK double DriveGuard::shape(double sample, double& wanted, std::int64_t frame,
                                            int position) noexcept {
  double y = sample;
  if (!std::isfinite(y)) {
    // Zero and not the last value: a fault that lasts must not leave DC on a coil.
    y = held_back(ceiling_, 0.0, GuardStage::NonFinite, frame, crest_frames_);
  }
  const double bounded = std::clamp(y, -ceiling_, ceiling_);
  if (bounded != y) y = held_back(y, bounded, GuardStage::Ceiling, frame, crest_frames_);
  if (heat_) y = scaled(y, heat_->gain().at(position), GuardStage::Heat);
  wanted = y *= gain_.at(frame);
  y = scaled(y, dc_.gain().at(position), GuardStage::Dc);
  const bool probing = feedback_.probing();
  const double last = probing ? last_allowed_ : last_;
  const double steep = within(y, last);
  if (steep != y) held_back(y, steep, GuardStage::Slew, frame, swing_frames_);
  double allowed = y = steep;
  if (excursion_) {
    allowed = excursion_->allow(steep, last_, position);
    y = within(allowed, last);
    if (y != steep) y = held_back(steep, y, GuardStage::Excursion, frame, crest_frames_);
  }
  feedback_.observe(sample, steep, position);
  last_allowed_ = y;
  if (probing) y = within(scaled(allowed, feedback_.gain_at(position), GuardStage::Feedback), last_);
  if (excursion_) excursion_->record(y, position);
  return last_ = y;
}

double DriveGuard::held_back(double from, double to, GuardStage::Index stage, std::int64_t frame,
                             std::int64_t hold) noexcept {
  count(std::abs(from - to), stage);
  feedback_.limited(frame, hold);
  return to;
}

double DriveGuard::scaled(double x, double gain, GuardStage::Index stage) noexcept {
  if (gain == 1.0 || x == 0.0) return x;
  count(std::abs(x) * (1.0 - gain), stage);
  return x * gain;
}

void DriveGuard::count(double less, GuardStage::Index stage) noexcept {
  auto& [frames, most] = counters_[stage];
  frames.store(frames.load(kRelaxed) + 1, kRelaxed);
  most.store(std::max(most.load(kRelaxed), less), kRelaxed);
}

GuardCounts DriveGuard::counts() const noexcept {
  GuardCounts counts;
  for (std::size_t s = 0; s < kGuardStages; ++s)
    counts[s] = {counters_[s].frames.load(kRelaxed), counters_[s].most.load(kRelaxed)};
  return counts;
}

/// Ceiling and slew.
double DriveGuard::within(double x, double last) const noexcept {
  return std::clamp(std::clamp(x, last - largest_step_, last + largest_step_), -ceiling_, ceiling_);
}

TACTUS_EVERY_BLOCK void DriveGuard::end_group(std::int64_t frame) noexcept {
  if (heat_) heat_->end_group();
  if (excursion_) excursion_->end_group();
  dc_.end_group();
  if (!feedback_.end_group(frame) || !is_open()) return;
  gain_.move_to(0.0, frame, fall_frames_);
  feedback_frame_ = frame;
}

}  // namespace tactus
