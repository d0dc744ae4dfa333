#include "engine/guard/feedback_probe.h"

#include <algorithm>
#include <cmath>

#include "engine/core/index.h"

namespace tactus {
namespace {

/// Lengths of the parts of the pattern in slots, the first at full gain.
constexpr std::array kRuns{3, 3, 3, 4, 4, 6, 5, 8, 7, 11, 10, 15, 14, 21, 19, 29, 27};
constexpr double kDip = 0.5;
constexpr double kMutePerGroup = 0.25, kReturnPerGroup = 0.0625;
constexpr double kFloor = 1e-4;         ///< of the power at the ceiling: quieter is silence
constexpr double kNearlySilent = 0.05;  ///< Np above the floor: nearly silent
constexpr int kLeastRuns = 7;
constexpr double kLeastGain = 0.9;
constexpr double kLeastT = 8.0;

/// Standard deviation that x must have, of the depth of the pattern: what smoothing leaves of it.
constexpr double kLeastShare = 0.2;

bool is_feedback(const FeedbackRegression& regression, int smoothing,
                 const FeedbackProbe::Reach& reach) noexcept {
  const auto fit = regression.fit();
  if (!(fit.response > reach.least_response && fit.response < reach.most_response)) return false;
  const double share = kLeastShare * std::log(kDip);
  if (!(fit.variance > share * share)) return false;
  const double ratio = regression.mean_r() - regression.mean_x();
  if (!(std::log(fit.response) + ratio > std::log(kLeastGain))) return false;
  return fit.t > kLeastT * (1.0 + 0.5 * std::log2(smoothing));
}

}  // namespace

FeedbackProbe::FeedbackProbe(Hertz sample_rate, double ceiling)
    : sample_rate_(sample_rate), ceiling_(ceiling), levels_(kSmoothings.size()) {}

int FeedbackProbe::groups_in(const Reach& reach) const noexcept {
  return std::max(1,
                  static_cast<int>(std::lround(sample_rate_.value / reach.slots_per_second / kGuardGroup)));
}

void FeedbackProbe::forget() noexcept {
  running_ = muted_ = false;
  gain_.move_to(1.0);
}

void FeedbackProbe::begin(const Reach& reach) noexcept {
  groups_ = groups_in(reach);
  reach_ = reach;
  floor_ = kFloor * ceiling_ * ceiling_ * kGuardGroup * groups_;
  running_ = true;
  group_ = slot_ = run_ = 0;
  left_ = kRuns.front();
  wanted_ = allowed_ = out_ = 0.0;
  for (auto& levels : levels_) levels.lags.fill({}), levels.fits.fill(0);
  gain_.move_to(1.0);
}

bool FeedbackProbe::end_group() noexcept {
  if (!running_) {
    gain_.move_to(muted_ ? std::max(0.0, gain_.now() - kMutePerGroup)
                         : std::min(1.0, gain_.now() + kReturnPerGroup));
    return false;
  }
  gain_.move_to(gain_.now());
  if (++group_ < groups_) return false;
  group_ = 0;
  return end_slot();
}

bool FeedbackProbe::end_slot() noexcept {
  runs_[index(slot_ % kLags)] = run_;
  bool found = false;
  for (std::size_t s = 0; s < levels_.size(); ++s) found = advance(levels_[s], kSmoothings[s]) || found;
  wanted_ = allowed_ = out_ = 0.0;
  ++slot_;
  if (--left_ == 0) next_run();
  return found;
}

/// One more slot in all lags of one smoothing.
bool FeedbackProbe::advance(Levels& levels, const Smoothing& smoothing) noexcept {
  const auto smooth = [this](double& now, double power, int slots) {
    const double next = power + floor_;
    now = slot_ == 0 ? next : now + (next - now) / std::min(slot_ + 1, slots);
  };
  smooth(levels.wanted, wanted_, smoothing.wanted);
  smooth(levels.allowed, allowed_, smoothing.out);
  smooth(levels.out, out_, smoothing.out);
  const auto place = index(slot_ % kLags);
  levels.u[place] = 0.5 * std::log(levels.allowed);
  levels.x[place] = 0.5 * std::log(levels.out / levels.allowed);
  const double a = 0.5 * std::log(levels.wanted);
  const double silent = 0.5 * std::log(floor_) + (reach_.lags > kShort.lags ? kNearlySilent : -1.0);
  bool found = false;
  for (int m = 0; m < reach_.lags && m <= slot_; ++m) {
    const auto from = index((slot_ - m) % kLags);
    if (a < silent && levels.u[from] < silent) continue;
    auto& lag = levels.lags[index(m)];
    lag.add(levels.x[from], a - levels.u[from]);
    auto& fits = levels.fits[index(m)];
    const bool fit = runs_[from] >= kLeastRuns && is_feedback(lag, smoothing.wanted, reach_);
    fits = fit ? static_cast<unsigned char>(std::min(fits + 1, reach_.least_fits)) : 0;
    found = found || fits == reach_.least_fits;
  }
  return found;
}

void FeedbackProbe::next_run() noexcept {
  ++run_;
  running_ = run_ < static_cast<int>(kRuns.size());
  if (running_) left_ = kRuns[index(run_)];
  gain_.move_to(running_ && run_ % 2 == 1 ? kDip : 1.0);
}

}  // namespace tactus
