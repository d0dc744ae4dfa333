#include "backends/take/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "engine/core/channels.h"
#include "engine/core/index.h"

namespace tactus {
namespace {

using Kind = JournalEntry::Kind;

void clear_non_finite(const ChannelBuffers& channels, int frames) {
  for (int c = 0; c < channels.size(); ++c)
    std::replace_if(
        channels[c], channels[c] + frames, [](double sample) { return !std::isfinite(sample); }, 0.0);
}

/// Calls play(done, frames) with block sizes in turn until `total` frames are done; it returns how many it
/// did.
template <class Play>
Status play_blocks(std::int64_t total, const std::vector<int>& block_frames, Play play) {
  std::size_t turn = 0;
  for (std::int64_t done = 0; done < total; ++turn) {
    const int size = block_frames[turn % block_frames.size()];
    const Result<int> frames = play(done, static_cast<int>(std::min<std::int64_t>(size, total - done)));
    if (!frames) return tl::unexpected(frames.error());
    done += *frames;
  }
  return {};
}

class TakePlayer {
 public:
  TakePlayer(const Take& take, WavReader& wav, const ReplayHost& host, int longest)
      : out(host.out_channels, longest),
        take_(take),
        wav_(wav),
        host_(host),
        longest_(longest),
        recorded_(static_cast<int>(take.header.inputs.size() + take.header.outputs.size()), longest),
        silence_(1, longest),
        entries_(take.header.state) {
    entries_.insert(entries_.end(), take.guard.begin(), take.guard.end());
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const auto& a, const auto& b) { return a.frame < b.frame; });
    for (const int sensor : host.sensors) in_.push_back(sensor < 0 ? silence_[0] : recorded_[sensor]);
  }

  Status prepare() {
    auto& guarded = host_.guarded;
    if (take_.header.trusted_sensors) guarded.disable_sensor_watch();
    const StreamFormat format{take_.header.sample_rate, static_cast<int>(in_.size()), host_.out_channels,
                              longest_};
    if (auto status = guarded.prepare(format); !status) return status;
    if (!take_.header.soft_start) guarded.skip_soft_start();
    return {};
  }

  /// At most `frames`, up to what must come between two blocks.
  Result<int> play(int frames) {
    if (auto status = between_blocks(); !status) return tl::unexpected(status.error());
    frames = static_cast<int>(std::min<std::int64_t>(frames, next_stop() - now_));
    if (auto status = post_until(now_ + frames); !status) return tl::unexpected(status.error());
    if (wav_.read(recorded_.data(), frames) != frames)
      return fail(Errc::BadFile, "", "the samples end before the end of the take",
                  "restore the file from a copy");
    host_.guarded.process({in_.data(), out.data(), frames});
    if (host_.same && !played.first_difference) compare(frames);
    now_ += frames;
    return frames;
  }

  ChannelBuffers out;
  Replayed played;

 private:
  bool is_halt(std::size_t entry) const { return entries_[entry].kind == Kind::Halt; }

  Status between_blocks() {
    if (auto status = post_until(now_ + 1); !status) return status;
    for (; next_edit_ < take_.edits.size() && take_.edits[next_edit_].frame <= now_; ++next_edit_)
      if (host_.replace)
        if (auto status = host_.replace(take_.edits[next_edit_]); !status) return status;
    return {};
  }

  std::int64_t next_stop() const {
    auto stop = now_ + longest_;
    if (next_edit_ < take_.edits.size()) stop = std::min(stop, take_.edits[next_edit_].frame);
    for (auto e = next_entry_; e < entries_.size() && entries_[e].frame < stop; ++e)
      if (is_halt(e)) stop = entries_[e].frame;
    return stop;
  }

  /// Entries before frame `end`. A halt is never inside a block.
  Status post_until(std::int64_t end) {
    for (; next_entry_ < entries_.size() && entries_[next_entry_].frame < end; ++next_entry_) {
      if (is_halt(next_entry_))
        while (!host_.guarded.finish({in_.data(), out.data(), 1})) continue;
      else if (!host_.guarded.post(entries_[next_entry_]))
        return fail(Errc::OutOfRange, "", fmt::format("too many guard events at frame {}", now_),
                    "use smaller blocks");
    }
    return {};
  }

  void compare(int frames) {
    const int sensors = static_cast<int>(take_.header.inputs.size());
    for (int n = 0; n < frames; ++n)
      for (int c = 0; c < out.size(); ++c) {
        const auto recorded = static_cast<float>(recorded_[sensors + c][n]);
        const auto replayed = as_recorded(out[c][n]);
        if (std::bit_cast<std::uint32_t>(recorded) == std::bit_cast<std::uint32_t>(replayed)) continue;
        played.first_difference = {now_ + n, c, recorded, replayed};
        return;
      }
  }

  const Take& take_;
  WavReader& wav_;
  const ReplayHost& host_;
  int longest_;
  ChannelBuffers recorded_, silence_;
  std::vector<const double*> in_;
  std::vector<JournalEntry> entries_;  ///< of the guard
  std::size_t next_entry_ = 0, next_edit_ = 0;
  std::int64_t& now_ = played.frames;
};

Status check(const Take& take, const WavReader& wav, const ReplayHost& host) {
  const auto channels = take.header.inputs.size() + take.header.outputs.size();
  if (wav.channels() != static_cast<int>(channels) || wav.sample_rate() != take.header.sample_rate)
    return fail(Errc::BadFile, "",
                fmt::format("the WAV file has {} channels at {} Hz, its journal {} at {} Hz", wav.channels(),
                            wav.sample_rate().value, channels, take.header.sample_rate.value),
                "use the two files of the same take");
  if (host.same && host.out_channels != static_cast<int>(take.header.outputs.size()))
    return fail(Errc::BadFile, "", "the outputs of the take's graph differ from the recorded ones", "");
  return {};
}

}  // namespace

OfflineInput offline_input(const Samples& samples) {
  const auto read = [&samples, at = std::int64_t{0}](double* const* to, int count) mutable {
    for (std::size_t c = 0; c < samples.channels.size(); ++c)
      std::copy_n(samples.channels[c].data() + at, count, to[c]);
    at += count;
  };
  return {samples.sample_rate, static_cast<int>(samples.channels.size()), samples.frames(), read};
}

Status run_offline(Guarded& processor, const OfflineInput& input, int out_channels,
                   const std::vector<int>& block_frames,
                   const std::function<Status(const double* const*, int)>& sink) {
  const int longest = *std::max_element(block_frames.begin(), block_frames.end());
  ChannelBuffers in{input.channels, longest}, out{out_channels, longest};
  if (auto status = processor.prepare({input.sample_rate, in.size(), out_channels, longest}); !status)
    return status;
  processor.skip_soft_start();
  processor.disable_sensor_watch();
  auto status = play_blocks(input.frames, block_frames, [&](std::int64_t, int frames) {
    input.read(in.data(), frames);
    clear_non_finite(in, frames);
    processor.process({in.data(), out.data(), frames});
    return sink(out.data(), frames).map([&] { return frames; });
  });
  processor.finish({in.data(), out.data(), block_frames.front()});
  return status;
}

std::int64_t frames_to_replay(const Take& take, const WavReader& wav) {
  return std::min(wav.frames(), take.complete);
}

Result<Replayed> replay(const Take& take, WavReader& wav, const ReplayHost& host,
                        const std::vector<int>& block_frames,
                        const std::function<Status(const double* const*, int)>& sink) {
  if (auto status = check(take, wav, host); !status) return tl::unexpected(status.error());
  TakePlayer player{take, wav, host, *std::max_element(block_frames.begin(), block_frames.end())};
  if (auto status = player.prepare(); !status) return tl::unexpected(status.error());
  const auto status = play_blocks(frames_to_replay(take, wav), block_frames, [&](std::int64_t, int frames) {
    return player.play(frames).and_then(
        [&](int played) { return sink(player.out.data(), played).map([&] { return played; }); });
  });
  if (!status) return tl::unexpected(status.error());
  return player.played;
}

}  // namespace tactus
