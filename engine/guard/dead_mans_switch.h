#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <limits>
#include <utility>

#include "engine/core/units.h"

namespace tactus {

/// [any] Between the loop that handles the stop inputs of a program (keys, signals) and the guards of its
/// outputs. The loop refreshes it many times a second; a guard fades every output out when it is older than
/// 500 ms, or when it is stopped. It outlives the guards that observe it.
class DeadMansSwitch {
 public:
  /// Since any instant.
  using Clock = std::chrono::nanoseconds (*)();
  static std::chrono::nanoseconds system_clock() {
    return std::chrono::steady_clock::now().time_since_epoch();
  }

  /// Without a refresh for so long a program does not go on by itself.
  static constexpr std::chrono::seconds kLong{5};

  explicit DeadMansSwitch(Clock clock = system_clock) : clock_(clock) {}

  /// By one thread alone.
  void refresh() noexcept {
    const auto now = clock_().count();
    const auto pause = now - last_.load(std::memory_order_relaxed);
    longest_.store(std::max(longest_.load(std::memory_order_relaxed), pause), std::memory_order_relaxed);
    if (pause >= std::chrono::nanoseconds{kLong}.count())
      long_pauses_.fetch_add(1, std::memory_order_relaxed);
    last_.store(now, std::memory_order_release);
    refreshes_.fetch_add(1, std::memory_order_relaxed);
  }
  /// Every output fades out, for good.
  void stop() noexcept { stopped_.store(true, std::memory_order_relaxed); }

  std::uint32_t refreshes() const noexcept { return refreshes_.load(std::memory_order_relaxed); }
  /// How many times it was not refreshed for five seconds or more, by the clock.
  std::uint32_t long_pauses() const noexcept { return long_pauses_.load(std::memory_order_relaxed); }
  bool stopped() const noexcept { return stopped_.load(std::memory_order_relaxed); }
  /// Since the last refresh, by the clock.
  Seconds age() const noexcept { return seconds(since_refresh()); }
  /// The longest time without a refresh until now, by the clock: the loop was blocked, or the whole
  /// program was stopped.
  Seconds longest_pause() const noexcept {
    const auto age = since_refresh();  // first: a refresh that follows changes nothing
    return seconds(std::max(age, longest_.load(std::memory_order_relaxed)));
  }

 private:
  using Count = std::chrono::nanoseconds::rep;
  Count since_refresh() const noexcept {
    const auto last = last_.load(std::memory_order_acquire);  // before the clock, which only goes on
    return clock_().count() - last;
  }
  static Seconds seconds(Count nanoseconds) noexcept {
    return Seconds{std::chrono::duration<double>{std::chrono::nanoseconds{nanoseconds}}.count()};
  }

  const Clock clock_;
  std::atomic<Count> last_{clock_().count()}, longest_{0};
  std::atomic<std::uint32_t> refreshes_{0}, long_pauses_{0};
  std::atomic<bool> stopped_{false};
};

/// The age of a DeadMansSwitch, counted in frames at the sample rate, so that it needs no clock and does not
/// advance where no block is processed. A refresh counts from the first frame of the block that observes it:
///   age >= 500 ms (or two of the longest blocks)  Expire
///   age >= 5 s, or 5 s by the clock               Disarm
///   refreshed after Expire                        Resume
class DeadMansWatch {
 public:
  enum class Action { None, Expire, Disarm, Resume };
  static constexpr Seconds kPatience{0.5},
      kDisarm{std::chrono::duration<double>{DeadMansSwitch::kLong}.count()};

  /// [control & stopped] From frame 0 on, where its age is 0. nullptr: none, and nothing expires.
  void start(const DeadMansSwitch* source, Hertz sample_rate, int max_frames, bool expired) noexcept {
    // Those since the stream before count.
    if (source != nullptr && source != source_) seen_pauses_ = source->long_pauses();
    source_ = source;
    const auto frames = [&](Seconds time) { return static_cast<std::int64_t>(frames_in(time, sample_rate)); };
    patience_ = std::max(frames(kPatience), 2 * std::int64_t{max_frames});
    disarm_ = std::max(frames(kDisarm), patience_);
    seen_ = source == nullptr ? 0 : source->refreshes();
    away_ = false;
    refreshed_ = 0;
    expired_ = expired;
    disarmed_ = false;
  }
  /// [realtime] At the first frame of a block: Resume or None.
  Action observe(std::int64_t frame) noexcept {
    if (source_ == nullptr) return Action::None;
    const auto refreshes = source_->refreshes();
    if (std::exchange(seen_, refreshes) == refreshes) return Action::None;
    refreshed_ = frame;
    const auto pauses = source_->long_pauses();
    away_ = std::exchange(seen_pauses_, pauses) != pauses && !disarmed_;
    disarmed_ = false;
    return std::exchange(expired_, false) ? Action::Resume : Action::None;
  }
  /// [realtime] After `observe`, once: by the clock it had not been refreshed for five seconds or more, and
  /// no Disarm came of it, as no blocks came meanwhile: the device stood still with the program.
  bool was_away() noexcept { return std::exchange(away_, false); }
  /// [realtime] The drives are disarmed until it is refreshed again.
  void set_disarmed() noexcept { disarmed_ = true; }
  /// [realtime] The frame of the next Expire or Disarm.
  std::int64_t next() const noexcept {
    if (source_ == nullptr || disarmed_) return std::numeric_limits<std::int64_t>::max();
    return refreshed_ + (expired_ ? disarm_ : patience_);
  }
  /// [realtime] What happens at `frame`. Once each.
  Action take(std::int64_t frame) noexcept {
    if (frame < next()) return Action::None;
    if (!std::exchange(expired_, true)) return Action::Expire;
    disarmed_ = true;
    return Action::Disarm;
  }

  /// [realtime] After five seconds or more without a block: it was refreshed less than once in 500 ms of
  /// them.
  bool slept(Seconds pause) const noexcept {
    return source_ != nullptr && pause >= kDisarm &&
           static_cast<double>(source_->refreshes() - seen_) * kPatience.value < pause.value;
  }

  /// [any]
  const DeadMansSwitch* source() const noexcept { return source_; }

 private:
  const DeadMansSwitch* source_ = nullptr;
  std::int64_t patience_ = 0, disarm_ = 0;  ///< frames
  std::int64_t refreshed_ = 0;              ///< the frame
  std::uint32_t seen_ = 0, seen_pauses_ = 0;
  bool expired_ = false, disarmed_ = false, away_ = false;
};

}  // namespace tactus
