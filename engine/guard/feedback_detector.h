#pragma once
// Thread: [realtime] unless stated otherwise

#include <cmath>
#include <cstdint>
#include <vector>

#include "engine/core/index.h"
#include "engine/core/units.h"
#include "engine/guard/feedback_growth.h"
#include "engine/guard/feedback_probe.h"
#include "engine/guard/feedback_trial.h"
#include "engine/guard/guard_group.h"

namespace tactus {

/// How an output may return to itself. An output with none of these is never taken for feedback.
struct FeedbackPath {
  bool from_input = true;     ///< a path leads to it from a device input: through air, a hand or an actuator
  bool internal_loop = true;  ///< a loop of the graph reaches it
  /// For takes of formats 1 and 2, whose guard took an output for feedback that was limited in more than half
  /// of 200 ms.
  bool limiting_counts = false;

  /// As one number: 1 for an input, 2 for a loop, 4 if limiting counts, and their sums.
  int bits() const noexcept {
    return (from_input ? 1 : 0) + (internal_loop ? 2 : 0) + (limiting_counts ? 4 : 0);
  }
  static FeedbackPath of(int bits) noexcept { return {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0}; }
  bool exists() const noexcept { return from_input || internal_loop || limiting_counts; }
  bool operator==(const FeedbackPath&) const = default;
};

/// Detects an unstable loop through an output. Such a loop does not stop at the limits by itself, so it is
/// looked for only while the output is limited; but limiting alone is no sign of it, since a loud signal is
/// limited too.
///
///   growth  (feedback_growth.h) limited in more than half of the last 200 ms, and what is wanted grows
///           without bound: a loop of the graph
///   probe   (feedback_probe.h) limited for 16 ms of the last 200 ms: what is wanted follows a pattern in
///           the output, through an input; a short pattern first, then a long one for long delays
///   trial   (feedback_trial.h) limited in more than half of the last 200 ms: the output is silenced at once,
///           and what is wanted falls whenever it is
///
/// A limited frame counts for a while after, because a loop may touch the limit only at its peaks. An outside
/// signal that stays limited is probed every 2 s, for long delays and by a trial every 10 s at most, or when
/// it is three times as loud as at the last trial.
class FeedbackDetector {
 public:
  static constexpr Seconds kWindow{0.2}, kLimited{0.016};

  /// [control]
  FeedbackDetector(const FeedbackPath& path, Hertz sample_rate, double ceiling)
      : path_(path),
        window_(index(groups_in(kWindow, sample_rate)) + 1),
        suspect_(index(groups_in(kLimited, sample_rate))),
        second_(groups_in(Seconds{1.0}, sample_rate)),
        growth_(sample_rate, ceiling),
        probe_(sample_rate, ceiling),
        trial_(sample_rate) {}

  const FeedbackPath& path() const noexcept { return path_; }
  void add(const FeedbackPath& path) noexcept { path_ = FeedbackPath::of(path_.bits() | path.bits()); }

  /// The gain is used.
  bool probing() const noexcept { return probe_.active() || trial_.active(); }
  double gain_at(int position) const noexcept { return probe_.gain_at(position); }
  /// The drive was limited at `frame`, which counts for `hold` frames.
  void limited(std::int64_t frame, std::int64_t hold) noexcept {
    if (frame + hold > until_) until_ = frame + hold;
  }
  /// A frame that does not pass as it is: what was wanted, and what ceiling, gains and slew limit left of it.
  void observe(double wanted, double allowed, int position) noexcept {
    constexpr double kMost = 1e60;  // its square is finite
    const double finite = std::abs(wanted) < kMost ? wanted : kMost;
    growth_.observe(finite);
    trial_.observe(finite);
    if (probing()) probe_.observe(finite, allowed, position);
  }
  /// The group before `frame` is over. True: feedback.
  bool end_group(std::int64_t frame) noexcept {
    const bool busy = until_ > frame - kGuardGroup;
    if (!path_.exists() || (!busy && count_ == 0 && resting_ == 0 && !probing())) return false;
    return update(busy);
  }
  void forget() noexcept;

 private:
  static int groups_in(Seconds time, Hertz sample_rate) {
    return static_cast<int>(frames_in(time, sample_rate) / kGuardGroup);
  }
  bool update(bool busy) noexcept;
  bool returns(bool suspect, bool mostly) noexcept;
  void begin_probe() noexcept;
  void rest(bool suspect) noexcept;

  FeedbackPath path_;
  std::vector<unsigned char> window_;  ///< of each group: was it limited
  std::size_t suspect_;                ///< limited groups that start a probe
  int second_;                         ///< groups
  std::size_t next_ = 0, count_ = 0;
  std::int64_t until_ = 0;
  int probe_rest_ = 0, long_rest_ = 0, trial_rest_ = 0, resting_ = 0;  ///< groups
  bool long_next_ = false;                                             ///< the next probe is for long delays
  bool outside_ = false;  ///< a trial has ended, and no pattern since
  FeedbackGrowth growth_;
  FeedbackProbe probe_;
  FeedbackTrial trial_;
};

}  // namespace tactus
