#pragma once
// Thread: [control]

#include <functional>
#include <vector>

#include "backends/wav_file.h"
#include "engine/guard/guarded.h"

namespace tactus {

/// Prepares `processor` and runs it on `input`, without hardware and without a clock, as fast as the machine
/// goes. Block sizes are used in turn and over again; the last block is as long as what is left. `sink` takes
/// each block of outputs. However the run ends, the processor gets one block more, in `Guarded::finish`.
/// Errors: BadArgument for the rate or a block size; those of `prepare` and of `sink`.
[[nodiscard]] Status run_offline(Guarded& processor, const Samples& input, int out_channels,
                                 const std::vector<int>& block_frames,
                                 const std::function<Status(const double* const* out, int frames)>& sink);

}  // namespace tactus
