#include "engine/guard/feedback_trial.h"

#include <utility>

#include "engine/core/index.h"

namespace tactus {
namespace {

constexpr double kFallen = 0.6, kBack = 0.5;                              ///< of the level before
constexpr int kLongestFall = 40, kLongestRise = 940, kLeastPlaying = 14;  ///< steps
constexpr int kNeeded = 4;
/// How long the drive plays before each silence, in times of the first fall: no rhythm falls with all of
/// them.
constexpr std::array kPlaying{1.5, 2.5, 2.0};

}  // namespace

void FeedbackTrial::begin() noexcept {
  go(State::First);
  group_ = cycles_ = 0;
  peak_ = 0.0;
  peaks_.fill(0.0);
}

FeedbackTrial::Verdict FeedbackTrial::end_group(bool limited) noexcept {
  if (!active() || ++group_ < groups_) return Verdict::None;
  group_ = 0;
  std::rotate(peaks_.begin(), peaks_.begin() + 1, peaks_.end());
  peaks_.back() = std::exchange(peak_, 0.0);
  ++steps_;
  const auto verdict = step(*std::ranges::max_element(peaks_), limited);
  if (verdict != Verdict::None) go(State::Idle);
  if (verdict == Verdict::Feedback) disagreements_ = 0;
  return verdict;
}

FeedbackTrial::Verdict FeedbackTrial::step(double level, bool limited) noexcept {
  if (state_ == State::Muted) return muted(level);
  if (state_ == State::Playing) return playing(level, limited);
  if (steps_ == std::ssize(peaks_)) {
    reference_ = level;
    go(State::Muted);
  }
  return Verdict::None;
}

FeedbackTrial::Verdict FeedbackTrial::muted(double level) noexcept {
  if (level > kFallen * reference_) {
    if (steps_ <= kLongestFall) return Verdict::None;
    disagreements_ = 0;
    return Verdict::Outside;
  }
  falls_[index(cycles_++)] = steps_;
  if (cycles_ == kNeeded) return judge();
  wait_ = kLeastPlaying + static_cast<int>(kPlaying[index(cycles_ - 1)] * falls_[0]);
  limited_again_ = false;
  highest_ = 0.0;
  go(State::Playing);
  return Verdict::None;
}

FeedbackTrial::Verdict FeedbackTrial::playing(double level, bool limited) noexcept {
  if (limited && level >= kBack * reference_) limited_again_ = true;
  if (!limited_again_) return steps_ > kLongestRise ? Verdict::Outside : Verdict::None;
  highest_ = std::max(highest_, level);
  if (level <= kFallen * highest_) {
    disagreements_ = 0;
    return Verdict::Outside;
  }
  if (--wait_ > 0) return Verdict::None;
  reference_ = level;
  go(State::Muted);
  return Verdict::None;
}

FeedbackTrial::Verdict FeedbackTrial::judge() noexcept {
  const auto [shortest, longest] = std::minmax_element(falls_.begin(), falls_.begin() + kNeeded);
  return *longest <= 2 * *shortest + 1 || ++disagreements_ == 2 ? Verdict::Feedback : Verdict::Outside;
}

}  // namespace tactus
