#pragma once

#include <vector>

#include "engine/core/block_io.h"
#include "engine/core/channels.h"

namespace tactus {

/// Between the card and an instrument, inside the guard: samples become the values that the instrument's
/// inputs count in, `padding` frames later.
///
///     value_i[n] = scale_i * sample_i[n - padding],    sample_i[n < 0] = 0
///
/// Outputs pass through. Bit for bit the same for every block size.
class RigInputs final : public BlockProcessor {
 public:
  /// [control] `inner` must outlive this. Inputs beyond the list have scale 1. padding_frames >= 0.
  RigInputs(BlockProcessor& inner, std::vector<double> scales, int padding_frames);

  /// [any] False when the samples would come through as they are: then leave this out.
  static bool needed(const std::vector<double>& scales, int padding_frames);

  /// [control & stopped] Errors: of `inner`.
  [[nodiscard]] Status prepare(const StreamFormat& format) override;
  /// [realtime & prepared]
  void process(const BlockIo& io) noexcept TACTUS_NONBLOCKING override;

 private:
  BlockProcessor& inner_;
  std::vector<double> scales_;
  int padding_frames_;
  int place_ = 0;        ///< in each ring: index of the oldest value
  ChannelBuffers past_;  ///< the last `padding` values, a ring for each input
  ChannelBuffers in_;
};

}  // namespace tactus
