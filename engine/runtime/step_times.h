#pragma once
// Thread: [control & stopped]

#include <functional>
#include <vector>

#include "engine/core/units.h"
#include "engine/runtime/player.h"

namespace tactus {

/// What the steps of a player take: of each the median over the blocks that are timed, which other programs
/// on the machine do not move. A timed block costs two readings of the clock per step, others nothing.
class StepTimes {
 public:
  /// Times one block in `every`, from the next one on. `player` outlives this.
  explicit StepTimes(Player& player, int every = 1);
  ~StepTimes() { player_.time_steps(false); }
  StepTimes(const StepTimes&) = delete;
  StepTimes& operator=(const StepTimes&) = delete;

  /// After each block of the player. Another version of the graph starts anew.
  void add(int frames);
  /// Of each step of the newest plan [ns per frame]; empty: no block was timed.
  std::vector<double> ns_per_frame() const;

 private:
  void start();

  Player& player_;
  const Plan* plan_ = nullptr;
  int every_, blocks_ = 0;
  std::vector<double> before_;
  std::vector<std::vector<double>> taken_;  ///< [step] of each timed block
};

/// Calls `run_block` for `duration`, or a few thousand times. Denormals are flushed to zero.
void repeat_block(Seconds duration, const std::function<void()>& run_block);

/// Runs a prepared player on inputs that stay at 1e-3, for `duration` or a few thousand blocks, and times
/// all of them: nanoseconds per frame of each step.
std::vector<double> time_steps(Player& player, int block, Seconds duration);

}  // namespace tactus
