#include "engine/guard/feedback_detector.h"

#include <algorithm>

#include "engine/core/every_block.h"

namespace tactus {

void FeedbackDetector::forget() noexcept {
  std::ranges::fill(window_, 0);
  count_ = 0;
  until_ = 0;
  long_next_ = outside_ = false;
  probe_rest_ = long_rest_ = trial_rest_ = resting_ = 0;
  growth_.forget();
  probe_.forget();
  trial_.forget();
}

/// Enters a group into the window.
TACTUS_EVERY_BLOCK bool FeedbackDetector::update(bool busy) noexcept {
  auto& oldest = window_[next_];
  count_ = count_ - oldest + (busy ? 1 : 0);
  oldest = busy ? 1 : 0;
  next_ = next_ + 1 == window_.size() ? 0 : next_ + 1;
  const bool mostly = 2 * count_ > window_.size();
  const bool grows = growth_.end_group() && mostly;
  if (count_ == 0) growth_.forget();
  return (path_.from_input && returns(busy && count_ > suspect_, mostly)) || (path_.internal_loop && grows) ||
         (path_.limiting_counts && mostly);
}

/// Whether the output returns through an input.
TACTUS_EVERY_BLOCK bool FeedbackDetector::returns(bool suspect, bool mostly) noexcept {
  const bool probed = probe_.running();
  const auto verdict = trial_.end_group(suspect);
  probe_.mute(trial_.is_muted());
  if (probe_.end_group() || verdict == FeedbackTrial::Verdict::Feedback) return true;
  if (trial_.active()) return false;
  rest(suspect);
  if (verdict == FeedbackTrial::Verdict::Outside) {
    probe_rest_ = 0;  // a whole pattern: what a mass does that nothing holds is unlike a fall
    trial_rest_ = 10 * second_;
    outside_ = true;
    long_rest_ = 0;
  } else if (probed && !probe_.running()) {
    long_next_ = long_rest_ == 0;
    probe_rest_ = long_next_ && outside_ ? 0 : 2 * second_;
    outside_ = false;
  }
  if (mostly && trial_rest_ == 0) {
    probe_.stop();
    trial_.begin();
  } else if (suspect && !probe_.running() && probe_rest_ == 0) {
    begin_probe();
  }
  return false;
}

TACTUS_EVERY_BLOCK void FeedbackDetector::begin_probe() noexcept {
  probe_.begin(long_next_ ? FeedbackProbe::kLong : FeedbackProbe::kShort);
  if (long_next_) long_rest_ = 10 * second_;
  long_next_ = false;
}

/// Counts the rests down; two seconds after the last limit everything starts again.
TACTUS_EVERY_BLOCK void FeedbackDetector::rest(bool suspect) noexcept {
  probe_rest_ = std::max(0, probe_rest_ - 1);
  long_rest_ = std::max(0, long_rest_ - 1);
  trial_rest_ = std::max(0, trial_rest_ - 1);
  resting_ = suspect ? 2 * second_ : std::max(0, resting_ - 1);
  if (resting_ == 0 || (suspect && trial_.is_louder())) trial_rest_ = 0;
  if (resting_ == 0) long_rest_ = 0;
}

}  // namespace tactus
