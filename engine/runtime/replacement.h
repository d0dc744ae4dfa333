#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/error.h"
#include "engine/runtime/running.h"

namespace tactus {

/// How often a node gave a non-finite value.
struct FaultCount {
  std::string path;
  std::int64_t count = 0;
};

/// What an edit of a running graph adds to one output so that it does not jump:
///   y(n) = x(n) + d (1 - (n - start) / length) until n = start + length,   d = y(start - 1) - x(start)
/// The first sample after the edit is the last one before it; from there on a step of y is one of x and
/// |d| / length at most.
class OutputFade {
 public:
  /// [realtime] The next sample comes from another graph; `last` is the one before it.
  void begin(std::int64_t frame, std::int64_t frames, double last) noexcept {
    ramp_ = {0.0, 0.0, frame, frames};
    last_ = last;
    jump_unknown_ = true;
  }
  /// [realtime] What is added at a frame.
  double at(std::int64_t frame) const noexcept {
    return ramp_.done(frame) ? 0.0 : ramp_.from * ramp_.remaining(frame);
  }
  /// [realtime] In place.
  void process(double* samples, int frames, std::int64_t first_frame) noexcept {
    if (std::exchange(jump_unknown_, false)) ramp_.from = last_ - samples[0];
    const std::int64_t end = ramp_.start + ramp_.length;
    for (std::int64_t n = first_frame; n < end && n < first_frame + frames; ++n)
      samples[n - first_frame] += at(n);
  }

 private:
  Ramp ramp_;
  double last_ = 0;
  bool jump_unknown_ = false;
};

/// The version of a graph that plays and, after an edit, the one that takes over from it. Versions are made
/// and freed on the control side; the audio side receives the next one through one atomic.
class Replacement {
 public:
  /// [control]
  explicit Replacement(std::unique_ptr<Plan> plan);

  /// [control & stopped] Only the newest version is left, and no fault is counted.
  Running& restart();
  /// [control, one thread] Makes the version that takes over at `frame`. Errors: BadArgument if
  /// sample rate, inputs, outputs or taps differ, or if the last version has not taken over yet.
  [[nodiscard]] Status offer(std::unique_ptr<Plan> plan, std::int64_t frame, int max_frames);
  /// [control, one thread] The last version has not taken over yet.
  bool waits() const { return before_ != nullptr && !retired_.load(std::memory_order_acquire); }
  /// [control, one thread] The newest version, which plays or is about to.
  const Running& newest() const { return *newest_; }
  /// [control, one thread] Counted by all versions.
  std::vector<FaultCount> faults() const;

  /// [realtime] The version to take over from the one that plays, or nullptr.
  Running* next() const noexcept { return incoming_.load(std::memory_order_acquire); }
  /// [realtime] It has taken over; the version before may be freed.
  void done() noexcept {
    incoming_.store(nullptr, std::memory_order_relaxed);
    retired_.store(true, std::memory_order_release);
  }

 private:
  void collect();

  std::unique_ptr<Running> newest_, before_;
  std::map<std::string, std::int64_t> past_faults_;  // of versions that are gone
  std::atomic<Running*> incoming_{nullptr};
  std::atomic<bool> retired_{false};  // `before_` no longer plays
};

}  // namespace tactus
