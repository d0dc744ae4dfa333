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

/// [0] is new, the rest moves up, and the last is forgotten.
template <class T, std::size_t kCount>
void push_front(std::array<T, kCount>& history, T value) {
  std::move_backward(history.begin(), history.end() - 1, history.end());
  history.front() = value;
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
  for (auto& levels : levels_) levels.regressions = {}, levels.fits.fill(0);
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
  push_front(runs_, run_);
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
  push_front(levels.u, 0.5 * std::log(levels.allowed));
  push_front(levels.x, 0.5 * std::log(levels.out / levels.allowed));
  const double a = 0.5 * std::log(levels.wanted);
  const double silent = 0.5 * std::log(floor_) + (reach_.lags > kShort.lags ? kNearlySilent : -1.0);
  const int lags = std::min(reach_.lags, slot_ + 1);
  Regressions::Values r, counts;
  for (std::size_t m = 0; m < index(lags); ++m) {
    r[m] = a - levels.u[m];
    counts[m] = a < silent && levels.u[m] < silent ? 0.0 : 1.0;
  }
  levels.regressions.add(levels.x, r, counts, lags);
  Regressions::Estimate estimate;
  levels.regressions.estimate(lags, estimate);
  bool found = false;
  for (std::size_t m = 0; m < index(lags); ++m) {
    if (counts[m] == 0.0) continue;
    const bool fit = is_feedback(levels.regressions, estimate, m, smoothing.wanted);
    auto& fits = levels.fits[m];
    fits = fit ? static_cast<unsigned char>(std::min(fits + 1, reach_.least_fits)) : 0;
    found = found || fits == reach_.least_fits;
  }
  return found;
}

bool FeedbackProbe::is_feedback(const Regressions& regressions, const Regressions::Estimate& estimate,
                                std::size_t lag, int smoothing) const noexcept {
  const double response = estimate.response[lag];
  if (!(response > reach_.least_response && response < reach_.most_response)) return false;
  if (runs_[lag] < kLeastRuns) return false;
  const double share = kLeastShare * std::log(kDip);
  if (!(estimate.variance[lag] > share * share)) return false;
  const double ratio = regressions.mean_r(lag) - regressions.mean_x(lag);
  if (!(std::log(response) + ratio > std::log(kLeastGain))) return false;
  return regressions.t(lag) > kLeastT * (1.0 + 0.5 * std::log2(smoothing));
}

void FeedbackProbe::next_run() noexcept {
  ++run_;
  running_ = run_ < static_cast<int>(kRuns.size());
  if (running_) left_ = kRuns[index(run_)];
  gain_.move_to(running_ && run_ % 2 == 1 ? kDip : 1.0);
}

}  // namespace tactus
