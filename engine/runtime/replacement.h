#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/runtime/running.h"

namespace tactus {

/// How often a node gave a non-finite value.
struct FaultCount {
  std::string path;
  std::int64_t count = 0;
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
