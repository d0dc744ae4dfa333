#pragma once

// Thread: [control] where not said otherwise.

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/core/ramp.h"
#include "engine/graph/plan/plan.h"
#include "engine/runtime/rate_divider.h"

namespace tactus {

/// A moving value that steps of a plan read: one number with stride 0 while it rests, a sample a frame
/// while it moves.
struct SmoothedControl {
  Ramp value;
  double* buffer = nullptr;  ///< nullptr: nothing reads it
  Readers readers;
  bool decibel = false;
  bool resting = true;

  /// [realtime]
  double at(std::int64_t frame) const noexcept { return decibel ? value.decibel_at(frame) : value.at(frame); }
};

/// A constant of the file that is read at one place and will move to a new value when the plan takes
/// over.
struct ConstantRamp {
  SmoothedControl control;
  int before = -1;  ///< the ramp of the plan before, if it has one for this place; its value then counts
  int divider = 0;  ///< of its reader
  std::vector<double> samples;
};

/// What carries over from the plan before, worked out on the control side (see Replacement).
struct Handover {
  struct Pair {
    int before, after;
  };
  std::vector<Pair> nodes;      ///< run on with their state
  std::vector<Pair> copies;     ///< continue as a node that another one runs on with
  std::vector<Pair> remade;     ///< made from other things: adopt what they can
  std::vector<Pair> silences;   ///< in Running::silent_until, of nodes that run on
  std::vector<Pair> controls;   ///< keep their value
  std::vector<bool> new_value;  ///< [of `controls`] the file gives it another value: it moves there
  std::vector<bool> jumps;      ///< [output] what feeds it is not the same
};

/// A channel and where its samples go.
struct LoadedInput {
  int channel;
  double* to;
};

/// A Plan and what the engine keeps beside it while it runs. Made and freed on the control side.
struct Running {
  /// [control] Allocates everything that `process` needs.
  Running(std::unique_ptr<Plan> plan, int max_frames);
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  /// [control & stopped] Everything back to frame 0.
  void start(int max_frames);
  /// [realtime] Sends a control from where it is to `target`, within its range and its time (`least_frames`
  /// or more). Does nothing if it is frozen.
  void move_control(std::size_t control, std::int64_t now, double target,
                    std::int64_t least_frames = 0) noexcept;
  /// [realtime] Puts a control at `value`, within its range, without a ramp. Does nothing if it is frozen.
  void set_control(std::size_t control, double value) noexcept;
  /// [realtime] The plan reads it.
  void set_system_delay(Seconds delay) noexcept;
  /// [realtime] Continues from the version before as in `handover`: nodes, controls and ramps.
  void take_over(Running& before, std::int64_t now, std::int64_t fade_frames) noexcept;
  /// [realtime] A step, or the loop that it begins, is silent until that frame.
  void silence(int step, std::int64_t until) noexcept {
    silent_until[index(step)] = std::max(silent_until[index(step)], until);
    quiet_from = std::max(quiet_from, until);
  }
  /// [realtime] From here on the signal is one number, or a sample a frame.
  void settle(int can_rest, bool resting) noexcept;
  /// [realtime] Advances by `frames` from `now`. Once for each sub-block, before its steps.
  void advance(std::int64_t now, int frames) noexcept {
    if (moving_ != 0 || has_own_rates_) advance_what_moves(now, frames);
  }

  const std::uint64_t number = next_number();  ///< no other version of any graph has it
  std::unique_ptr<Plan> plan;
  std::vector<SmoothedControl> controls;  ///< as Plan::controls
  std::vector<ConstantRamp> ramps;
  std::vector<int> control_of;                ///< [number, which never changes] index in `controls`; -1: gone
  std::vector<std::string> control_names;     ///< [number]
  std::vector<int> outputs;                   ///< channels that are not taps
  std::vector<const Signal*> output_signals;  ///< [output] in Plan::channels
  std::vector<LoadedInput> loaded_inputs;     ///< that something reads, beside Plan::input_lanes
  std::vector<bool> vectorised;               ///< [output] it and those behind it are the lanes of one signal
  std::vector<int> tap_channels;
  std::vector<std::vector<double>> taps;
  std::vector<Signal> moved_in;  ///< a step's operands at an offset into the sub-block
  std::vector<double*> moved_out;
  std::vector<std::atomic<std::int64_t>> faults;  ///< [vertex]
  std::vector<double> step_ns;
  std::vector<char> at_rest;  ///< as Plan::can_rest
  /// [as Plan::can_rest] its number was computed, and is finite, while `settings` was this; 0: it was not
  std::vector<std::uint64_t> computed_in;
  std::uint64_t settings = 1;         ///< counts what may change numbers at rest
  std::vector<RateDivider> dividers;  ///< as Plan::divisors; the first stays unused
  /// [step, of a loop its first] the frame where the silence after a fault ends.
  std::vector<std::int64_t> silent_until;
  std::int64_t quiet_from = 0;  ///< the latest of these frames

  std::int64_t frame = 0;  ///< the first that it is to run
  Handover handover;

 private:
  static std::uint64_t next_number() noexcept;
  void take_values(const Running& before, std::int64_t now, std::int64_t fade_frames) noexcept;
  bool begins_lanes(std::size_t output) const;
  void settle(SmoothedControl& control, bool resting) noexcept;
  void set_strides(const Readers& readers, int stride) noexcept;
  void advance_what_moves(std::int64_t now, int frames) noexcept;
  void advance(SmoothedControl& control, const RateDivider* divider, std::int64_t now, int frames) noexcept;

  bool has_own_rates_ = false;  ///< parts with a rate divider
  int moving_ = 0;              ///< controls and ramps in motion: a file may have thousands that are constant
};

}  // namespace tactus
