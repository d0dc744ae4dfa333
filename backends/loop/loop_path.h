#pragma once

#include <cstdint>
#include <optional>

#include "backends/loop/echo_canceller.h"
#include "backends/loop/loop_card.h"
#include "backends/loop/sinc_line.h"
#include "engine/dsp/envelopes/follower_kernel.h"
#include "engine/dsp/filters/linear_filter.h"
#include "engine/dsp/generators/counter_noise.h"

namespace tactus {

/// Where the frames of an opening go, the same for all its channels.
struct LoopTiming {
  Hertz sample_rate = 48_kHz;
  int block_frames = 64;
  int buffer_frames = 0;         ///< from the processor to the converter
  double hardware_frames = 0.0;  ///< from the output converter to the input converter
};

/// The way from one output to one input.
class LoopPath {
 public:
  /// [control] `lane`: each has noise of its own.
  LoopPath(const LoopCard& card, const LoopTiming& timing, int lane);

  /// [realtime] What comes in at `frame`, `later` frames later than usual. Frames come one after another.
  double record(std::int64_t frame, double later) noexcept;
  /// [realtime] What goes out at `frame`; all of a block at once, after it was recorded.
  void play(std::int64_t frame, double sample) noexcept;

 private:
  double converted(double sample) const noexcept;
  double controlled(double sample) noexcept;

  LoopCard card_;
  LoopTiming timing_;
  SincLine line_;   ///< what the output plays
  SincLine heard_;  ///< for the monitor
  CounterNoise noise_;
  std::optional<LinearFilter<1>> high_pass_;
  std::optional<EchoCanceller> canceller_;
  tactus_follower level_{};
  double attack_keep_, release_keep_;
  double step_;
  int monitor_frames_;
  bool played_ = false;  ///< anything yet
};

}  // namespace tactus
