#include "backends/offline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/channels.h"
#include "engine/core/index.h"

namespace tactus {
namespace {

constexpr int kMaxOfflineBlock = 1 << 20;

Status check(const Samples& input, const std::vector<int>& block_frames) {
  if (!(input.sample_rate.value > 0.0 && std::isfinite(input.sample_rate.value)))
    return fail(Errc::BadArgument, "", fmt::format("{} Hz is not a sample rate", input.sample_rate.value),
                "");
  const auto fits = [](int frames) { return frames >= 1 && frames <= kMaxOfflineBlock; };
  if (block_frames.empty() || !std::all_of(block_frames.begin(), block_frames.end(), fits))
    return fail(Errc::BadArgument, "", "the block size is missing or out of range",
                fmt::format("give 1 to {} frames", kMaxOfflineBlock));
  return {};
}

/// Copies a block of `input`; non-finite samples become 0.
void copy_block(const Samples& input, std::int64_t at, int frames, const ChannelBuffers& to) {
  for (int c = 0; c < to.size(); ++c)
    std::transform(input.channels[index(c)].data() + at, input.channels[index(c)].data() + at + frames, to[c],
                   [](double sample) { return std::isfinite(sample) ? sample : 0.0; });
}

}  // namespace

Status run_offline(Guarded& processor, const Samples& input, int out_channels,
                   const std::vector<int>& block_frames,
                   const std::function<Status(const double* const*, int)>& sink) {
  if (auto status = check(input, block_frames); !status) return status;
  const int longest = *std::max_element(block_frames.begin(), block_frames.end());
  ChannelBuffers in{static_cast<int>(input.channels.size()), longest}, out{out_channels, longest};
  if (auto status = processor.prepare({input.sample_rate, in.size(), out_channels, longest}); !status)
    return status;
  processor.skip_soft_start();
  processor.disable_sensor_watch();
  Status status;
  int frames = 0;
  for (std::int64_t done = 0, turn = 0; status && done < input.frames(); done += frames, ++turn) {
    const int size = block_frames[index(turn) % block_frames.size()];
    frames = static_cast<int>(std::min<std::int64_t>(size, input.frames() - done));
    copy_block(input, done, frames, in);
    processor.process({in.data(), out.data(), frames});
    status = sink(out.data(), frames);
  }
  processor.finish({in.data(), out.data(), block_frames.front()});
  return status;
}

}  // namespace tactus
