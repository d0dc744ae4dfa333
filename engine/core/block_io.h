#pragma once

#include "engine/core/error.h"
#include "engine/core/realtime.h"
#include "engine/core/units.h"

namespace tactus {

/// What a stream was opened with. `max_frames` bounds every later block.
struct StreamFormat {
  Hertz sample_rate = 48_kHz;
  int in_channels = 0;
  int out_channels = 0;
  int max_frames = 4096;
};

/// Where channels of two devices are numbered, those from this number on are of the second one.
inline constexpr int kSecondDevice = 1024;

/// One block of samples, channel by channel: `in[channel][frame]`, full scale = 1.
struct BlockIo {
  const double* const* in = nullptr;
  double* const* out = nullptr;
  int frames = 0;
};

/// The interface between processors of samples (engine, latency probe) and backends.
class BlockProcessor {
 public:
  virtual ~BlockProcessor() = default;
  /// [control & stopped] Allocates all that `process` needs. Errors: BadArgument if `format` does not fit.
  [[nodiscard]] virtual Status prepare(const StreamFormat& format) = 0;
  /// [realtime & prepared] Reads `io.in`, fills every sample of `io.out`. 1 <= io.frames <= max_frames.
  virtual void process(const BlockIo& io) noexcept TACTUS_NONBLOCKING = 0;
};

}  // namespace tactus
