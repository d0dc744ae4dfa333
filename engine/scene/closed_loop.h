#pragma once

#include <functional>
#include <vector>

#include "engine/core/block_io.h"
#include "engine/core/channels.h"
#include "engine/runtime/player.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// An instrument playing in a simulated world:
///
///     plant ──sensors──► ADC ──► instrument ──drives──► DAC ──► ring of D frames ──► plant
///
/// D is exact: what the instrument answers to the sensors of frame n moves the plant from frame n + D on. It
/// runs in blocks of min(block, max(1, D)) frames; with D = 0 the plant calls the instrument in the middle of
/// its frame (its schedule must have been compiled with `closed_outside`). The converters quantise to `bits`
/// and clip at full scale; sensors with a unit do not clip, because nothing says what their full scale is.
class ClosedLoop : private BlockProcessor {
 public:
  /// [control] Both must outlive this; the instrument comes guarded, like on any backend.
  ClosedLoop(BlockProcessor& instrument, Player& plant, int instrument_outputs, int delay_frames,
             Converters converters);
  ClosedLoop(const ClosedLoop&) = delete;
  ClosedLoop& operator=(const ClosedLoop&) = delete;

  /// [control & stopped] Silence in the ring, frame 0.
  [[nodiscard]] Status prepare(Hertz sample_rate, int max_block);

  /// One block: samples after the converters.
  struct Block {
    int frames;
    const ChannelBuffers& sensors;
    const ChannelBuffers& drives;  ///< of the instrument, before the delay
  };
  using Listener = std::function<void(const Block&)>;

  /// [control] Sensors with a unit, whose ends a sensor watch cannot know.
  bool has_units() const;
  /// [control] Runs `frames` frames; `listener` receives every block.
  void run(int frames, const Listener& listener = {});

 private:
  Status prepare(const StreamFormat&) override { return {}; }
  /// With no delay at all the plant runs first and calls the instrument from within its frame.
  void process(const BlockIo& io) noexcept override;
  void convert(double* samples, int frames, bool clips) const noexcept;
  void answer(int frames) noexcept;
  void run_block(int frames) noexcept;

  BlockProcessor& instrument_;
  Player& plant_;
  int delay_;
  Converters converters_;
  double steps_;  ///< quantisation steps from 0 to full scale
  int block_ = 0;
  int sensor_count_, drive_count_;
  std::vector<char> clips_;  ///< [sensor] 0: it has a unit
  ChannelBuffers sensors_, drives_, delayed_, unused_;
  std::vector<std::vector<double>> ring_;  ///< [drive][frame mod size]
  std::size_t written_ = 0;
};

}  // namespace tactus
