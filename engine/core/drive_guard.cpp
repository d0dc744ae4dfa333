#include "engine/core/drive_guard.h"

#include <algorithm>
#include <cmath>

namespace tactus {

Status check(const DriveLimits& limits) {
  // Written so that a NaN fails every one of them.
  if (!(limits.ceiling > 0.0 && limits.ceiling <= 1.0))
    return fail(Errc::OutOfRange, "", "the ceiling of a drive lies outside (0, 1] full scale",
                "give it as a fraction of what the converter can put out");
  if (!(limits.slew_per_second > 0.0))
    return fail(Errc::OutOfRange, "", "the slew limit of a drive is not positive",
                "leave it out for no limit, or give full scales a second");
  if (!(limits.soft_start.value >= 0.0 && limits.soft_start.value <= 60.0))
    return fail(Errc::OutOfRange, "", "the soft start of a drive lies outside 0 s to 60 s", "");
  if (!(limits.fade_out.value >= 0.0 && limits.fade_out.value <= 1.0))
    return fail(Errc::OutOfRange, "", "the fade out of a drive lies outside 0 s to 1 s", "");
  return {};
}

DriveGuard::DriveGuard(Kind kind, const DriveLimits& limits, Hertz sample_rate)
    : kind_(kind),
      ceiling_(limits.ceiling),
      largest_step_(limits.slew_per_second / sample_rate.value),
      rise_frames_(std::llround(frames_in(limits.soft_start, sample_rate))),
      fall_frames_(std::llround(frames_in(limits.fade_out, sample_rate))) {}

void DriveGuard::set_open(bool open, std::int64_t frame) noexcept {
  if (open == is_open()) return;
  gain_.begin(frame, open ? rise_frames_ : fall_frames_, open ? 1.0 : 0.0);
}

void DriveGuard::process(double* samples, int frames, std::int64_t first_frame) noexcept {
  make_finite(samples, frames);
  apply_gain(samples, frames, first_frame);
  apply_ceiling(samples, frames);
  if (kind_ == Kind::Drive) apply_slew(samples, frames);
}

void DriveGuard::make_finite(double* samples, int frames) noexcept {
  int bad = 0;
  for (int n = 0; n < frames; ++n) {
    // Zero and not the last value: a fault that lasts must not hold a coil under direct current.
    const bool finite = std::isfinite(samples[n]);
    bad += finite ? 0 : 1;
    samples[n] = finite ? samples[n] : 0.0;
  }
  counts_.nonfinite += bad;
}

void DriveGuard::apply_gain(double* samples, int frames, std::int64_t first_frame) noexcept {
  if (gain_.at_rest(first_frame) && gain_.target() == 1.0) return;
  for (int n = 0; n < frames; ++n) samples[n] *= gain_.at(first_frame + n);
}

void DriveGuard::apply_ceiling(double* samples, int frames) noexcept {
  int hits = 0;
  for (int n = 0; n < frames; ++n) {
    hits += std::abs(samples[n]) > ceiling_ ? 1 : 0;
    samples[n] = std::clamp(samples[n], -ceiling_, ceiling_);
  }
  counts_.ceiling += hits;
}

void DriveGuard::apply_slew(double* samples, int frames) noexcept {
  if (std::isinf(largest_step_)) return;
  int hits = 0;
  double last = last_;
  for (int n = 0; n < frames; ++n) {
    const double wanted = samples[n];
    last = std::clamp(wanted, last - largest_step_, last + largest_step_);
    hits += last != wanted ? 1 : 0;
    samples[n] = last;
  }
  last_ = last;
  counts_.slew += hits;
}

}  // namespace tactus
