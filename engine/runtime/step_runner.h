#pragma once

// Thread: [control].

#include <cstdint>

#include "engine/runtime/running.h"

namespace tactus {

/// What answers at a plan's `Outside` step.
class Outside {
 public:
  /// [realtime] For `frames` frames from `offset` into the sub-block on.
  virtual void answer(int offset, int frames) noexcept = 0;

 protected:
  ~Outside() = default;
};

/// Runs the steps of a plan over one sub-block. A non-finite value of a step silences it, or the loop that it
/// lies in, to the end of its cell on a grid of kMaxSubBlock frames, and resets it: so the output does not
/// depend on the blocks either. Its vertex is counted.
class StepRunner {
 public:
  explicit StepRunner(Outside& outside) : outside_(outside) {}

  /// [realtime] Runs the steps of `running` from now on.
  void use(Running& running) noexcept {
    running_ = &running;
    plan_ = running.plan.get();
  }
  /// [realtime] Frames [now, now + frames). With `kTimed` it adds the time of each step to Running::step_ns.
  template <bool kTimed>
  void run(std::int64_t now, int frames) noexcept;

 private:
  static constexpr int kSound = -1;
  /// The first non-finite frame of a step, and its vertex.
  struct Fault {
    int vertex = kSound;
    int frame = kMaxSubBlock;
  };

  template <bool kTimed>
  void run_straight(const Section& section, int frames) noexcept;
  template <bool kTimed>
  void run_loop(const Section& section, int frames) noexcept;
  bool run_node(const Step& step, const NodeBlock& block) noexcept;
  [[gnu::noinline]] static bool gave_finite(const Step& step, const NodeBlock& block) noexcept;
  Fault run_operations(const Step& step, bool loop, int offset, int frames) noexcept;
  [[gnu::noinline]] Fault run_operations_once(const Step& step, bool loop, int offset) noexcept;
  // Where a step is at another rate, is silent or becomes so, and loops that are shorter than a block.
  [[gnu::noinline]] void run_with_care(int step, int frames) noexcept;
  [[gnu::noinline]] void run_silent(int step, int offset, int frames) noexcept;
  [[gnu::noinline]] int begin_silence(int step, const Fault& fault, int offset) noexcept;
  template <bool kTimed>
  [[gnu::noinline]] void run_loop_in_parts(const Section& section, int frames) noexcept;
  template <bool kTimed>
  void run_frame(const Section& section, int offset) noexcept;
  template <bool kTimed>
  [[gnu::noinline]] void run_part(const Section& section, int step, Fault fault, int offset,
                                  int part) noexcept;
  void silence_part(const Section& section, int offset, int part) noexcept;
  Fault run_step(const Step& step, bool loop, int offset, int frames) noexcept;
  [[gnu::noinline]] Fault made_finite(const Step& step, const NodeBlock& block, int offset) noexcept;
  [[gnu::noinline]] static void run_moved(const MicroOperation& operation, int offset, int frames) noexcept;
  [[gnu::noinline]] void clear(const MicroOperation& operation, bool loop, double* out, int frames,
                               Fault& first) noexcept;
  bool is_at_rest(const MicroOperation& operation, int frames) noexcept;
  [[gnu::noinline]] bool run_at_rest(const MicroOperation& operation, int frames) noexcept;
  // Steps of a part with a rate divider, and at its border.
  [[gnu::noinline]] Fault run_divided(const Step& step, bool loop, int offset, int frames) noexcept;
  void move_divided(const Step& step, int offset, NodeBlock& block) noexcept;
  [[gnu::noinline]] void move(const Step& step, int from, int apart, int to, NodeBlock& block) noexcept;
  /// nullptr: none.
  const RateDivider* divider(int of) const noexcept {
    return of == 0 ? nullptr : &running_->dividers[index(of)];
  }
  [[gnu::noinline]] static Fault fault_of(const Step& step, const NodeBlock& block) noexcept;
  void count_fault(int vertex, int times = 1) noexcept;
  void reset(const Step& step) noexcept;
  void silence(const Step& step, int offset, int frames) noexcept;

  Outside& outside_;
  Running* running_ = nullptr;
  const Plan* plan_ = nullptr;
  std::int64_t now_ = 0;
};

}  // namespace tactus
