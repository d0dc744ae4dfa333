#include "engine/guard/feedback_trial.h"

#include <utility>

#include "engine/core/every_block.h"

namespace tactus {
namespace {

constexpr double kFallen = 0.6, kFallenPlaying = 0.5, kBack = 0.4;  ///< of the level before
constexpr double kSteady = 0.95, kSilent = 0.55;                    ///< the same
constexpr double kSwinging = 0.3;                                   ///< of the swing before
constexpr double kRise = 1.2, kRiseShare = 0.03;  ///< of the lowest level, and of the level before
constexpr int kSteadySteps = 20, kLongestFall = 47, kSilentSteps = 30, kSilentFalls = 2;
constexpr int kLongestRise = 940, kRiseFalls = 30, kLeastPlaying = 18;
constexpr int kSecond = 94;       ///< in steps
constexpr double kRisesBy = 1.1;  ///< each second, a loop that is slow to be limited again
constexpr double kPlayingFalls = 1.5;

}  // namespace

void FeedbackTrial::begin() noexcept {
  falls_ = last_fall_ = fall_ = 0;
  mute();
}

void FeedbackTrial::mute() noexcept {
  go(State::Falling);
  reference_ = highest_ = level();
  swing_ = swing();
}

TACTUS_EVERY_BLOCK FeedbackTrial::Verdict FeedbackTrial::end_group(bool limited) noexcept {
  if (++group_ < groups_) return Verdict::None;
  group_ = 0;
  std::rotate(ranges_.begin(), ranges_.begin() + 1, ranges_.end());
  ranges_.back() = std::exchange(now_, {});
  if (!active()) return Verdict::None;
  ++steps_;
  const auto verdict = step(level(), limited);
  if (verdict == Verdict::Outside) go(State::Idle);  // a loop stays silent until it is forgotten
  return verdict;
}

FeedbackTrial::Verdict FeedbackTrial::step(double level, bool limited) noexcept {
  if (state_ == State::Falling) return falling(level);
  if (state_ == State::Silent) return silent(level);
  return playing(level, limited);
}

FeedbackTrial::Verdict FeedbackTrial::falling(double level) noexcept {
  if (level > kFallen * reference_) {
    highest_ = std::max(highest_, level);
    const bool steady =
        steps_ >= kSteadySteps && level > kSteady * highest_ && last_swing() > kSwinging * swing_;
    return steady || steps_ > kLongestFall ? outside() : Verdict::None;
  }
  fall_ = steps_;
  go(State::Silent);
  return Verdict::None;
}

FeedbackTrial::Verdict FeedbackTrial::silent(double level) noexcept {
  lowest_ = steps_ == 1 ? level : std::min(lowest_, level);
  if (level > kRise * lowest_ + kRiseShare * reference_) return outside();
  if (steps_ < kSilentSteps + kSilentFalls * fall_) return Verdict::None;
  if (level > kSilent * reference_) return outside();
  if (++falls_ > 1)
    if (const auto verdict = judge(); verdict != Verdict::None) return verdict;
  last_fall_ = fall_;
  wait_ = kLeastPlaying + static_cast<int>(kPlayingFalls * fall_);
  limited_again_ = false;
  highest_ = risen_ = 0.0;
  go(State::Playing);
  return Verdict::None;
}

FeedbackTrial::Verdict FeedbackTrial::playing(double level, bool limited) noexcept {
  if (limited && level > kBack * reference_) limited_again_ = true;
  if (!limited_again_) return waits_on(level) ? Verdict::None : outside();
  highest_ = std::max(highest_, level);
  if (level < kFallenPlaying * highest_) return outside();
  if (--wait_ > 0 || last_swing() <= kSwinging * swing()) return Verdict::None;
  mute();
  return Verdict::None;
}

/// Whether the drive may still be limited again; notes how the level rises.
bool FeedbackTrial::waits_on(double level) noexcept {
  if (steps_ % kSecond == 0) {
    rises_ = level > kRisesBy * risen_;
    risen_ = level;
  }
  return rises_ || steps_ <= kLongestRise + kRiseFalls * fall_;
}

FeedbackTrial::Verdict FeedbackTrial::outside() noexcept {
  disagreements_ = 0;
  return Verdict::Outside;
}

FeedbackTrial::Verdict FeedbackTrial::judge() noexcept {
  const auto [shorter, longer] = std::minmax(last_fall_, fall_);
  const bool alike = longer <= 2 * shorter + 1, equal = longer - shorter <= 1 + shorter / 8;
  if (alike && !equal && falls_ == 2) return Verdict::None;
  if (!alike && ++disagreements_ < 2) return Verdict::Outside;
  disagreements_ = 0;
  return Verdict::Feedback;
}

}  // namespace tactus
