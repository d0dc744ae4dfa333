#include "backends/offline/offline.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "engine/core/channels.h"
#include "engine/core/index.h"

namespace tactus {
namespace {

constexpr const char* kDeviceId = "offline:files";
constexpr int kLongestBlock = 1 << 20;
constexpr int kMostChannels = 1024;

Status check(const OfflineJob& job) {
  if (!(job.sample_rate.value > 0.0 && std::isfinite(job.sample_rate.value)))
    return fail(Errc::BadArgument, "", fmt::format("{} Hz is no sample rate", job.sample_rate.value), "");
  if (job.in_channels < 0 || job.out_channels < 0 || job.frames < 0)
    return fail(Errc::BadArgument, "", "channels and frames cannot be negative", "");
  if (job.in_channels > kMostChannels || job.out_channels > kMostChannels)
    return fail(Errc::BadArgument, "", fmt::format("there are at most {} channels", kMostChannels), "");
  if (job.source.read && job.source.channels != job.in_channels)
    return fail(
        Errc::BadArgument, "",
        fmt::format("the input has {} channels, but {} are wanted", job.source.channels, job.in_channels),
        "give a file with as many channels as the instrument has inputs");
  if (job.sink.write && job.sink.channels != job.out_channels)
    return fail(
        Errc::BadArgument, "",
        fmt::format("{} channels are to be written, but there are {}", job.sink.channels, job.out_channels),
        "");
  const auto fits = [](int frames) { return frames >= 1 && frames <= kLongestBlock; };
  if (job.block_frames.empty() || !std::all_of(job.block_frames.begin(), job.block_frames.end(), fits))
    return fail(Errc::BadArgument, "", "there is no block size, or one that is out of range",
                fmt::format("give 1 to {} frames", kLongestBlock));
  return {};
}

StreamFormat format_of(const OfflineJob& job) {
  return {job.sample_rate, job.in_channels, job.out_channels,
          *std::max_element(job.block_frames.begin(), job.block_frames.end())};
}

/// Non-finite samples among the first `frames` become 0; returns how many.
std::int64_t make_finite(const ChannelBuffers& channels, int frames) {
  std::int64_t bad = 0;
  for (double* const samples : channels)
    for (int n = 0; n < frames; ++n) {
      if (std::isfinite(samples[n])) continue;
      samples[n] = 0.0;
      ++bad;
    }
  return bad;
}

/// The frames of a job.
Status play_blocks(Guarded& processor, const OfflineJob& job, HealthMeter& meter, ChannelBuffers& in,
                   ChannelBuffers& out) {
  using Clock = std::chrono::steady_clock;
  std::size_t turn = 0;
  for (std::int64_t done = 0; done < job.frames;) {
    const int size = job.block_frames[turn++ % job.block_frames.size()];
    const int frames = static_cast<int>(std::min<std::int64_t>(size, job.frames - done));
    if (job.source.read) {
      if (auto status = job.source.read(in.data(), frames); !status) return status;
      meter.bad_input(make_finite(in, frames));
    }
    const auto begin = Clock::now();
    processor.process({in.data(), out.data(), frames});
    const std::chrono::duration<double> busy = Clock::now() - begin;
    meter.block(frames, busy.count() * job.sample_rate.value / frames);
    if (job.sink.write)
      if (auto status = job.sink.write(out.data(), frames); !status) return status;
    done += frames;
  }
  return {};
}

/// Runs the frames of a job through a processor that is prepared for it, and the zeros behind them.
Status run_blocks(Guarded& processor, const OfflineJob& job, HealthMeter& meter) {
  const int longest = format_of(job).max_frames;
  ChannelBuffers in{job.in_channels, longest}, out{job.out_channels, longest};
  processor.skip_soft_start();
  if (job.source.read) processor.disable_sensor_watch();
  const auto played = play_blocks(processor, job, meter, in, out);
  processor.finish({in.data(), out.data(), job.block_frames.front()});
  const auto finished = job.sink.finish ? job.sink.finish(out.data(), job.block_frames.front()) : Status{};
  return played ? finished : played;
}

class OfflineStream final : public Stream {
 public:
  OfflineStream(OfflineJob job, Guarded& processor) : job_(std::move(job)), processor_(processor) {
    granted_.device = kDeviceId;
    granted_.format = format_of(job_);
    granted_.block_frames = job_.block_frames.size() == 1 ? job_.block_frames.front() : 0;
    granted_.input_latency_frames = granted_.output_latency_frames = 0.0;
  }

  const StreamGranted& granted() const override { return granted_; }
  Status start() override {
    if (state_ != StreamState::Stopped)
      return fail(Errc::Device, kDeviceId, "this run is over", "open the device again");
    state_ = StreamState::Finished;
    return run_blocks(processor_, job_, meter_);
  }
  Status stop() override { return {}; }
  StreamState state() const override { return state_; }
  Health health() const override { return meter_.read(); }

 private:
  OfflineJob job_;
  Guarded& processor_;
  StreamGranted granted_;
  StreamState state_ = StreamState::Stopped;
  HealthMeter meter_;
};

}  // namespace

FrameSource source_of(const Samples& samples) {
  auto read = [&samples, at = std::int64_t{0}](double* const* channels, int frames) mutable -> Status {
    const auto there = std::min<std::int64_t>(samples.frames() - at, frames);
    for (std::size_t c = 0; c < samples.channels.size(); ++c)
      std::fill(std::copy_n(samples.channels[c].data() + at, there, channels[c]), channels[c] + frames, 0.0);
    at += there;
    return {};
  };
  return {static_cast<int>(samples.channels.size()), std::move(read)};
}

FrameSource source_of(WavReader& reader) {
  return {reader.channels(), [&reader](double* const* channels, int frames) -> Status {
            reader.read(channels, frames);
            return {};
          }};
}

FrameSink sink_into(Samples& samples) {
  return {static_cast<int>(samples.channels.size()),
          [&samples](const double* const* channels, int frames) -> Status {
            for (std::size_t c = 0; c < samples.channels.size(); ++c)
              samples.channels[c].insert(samples.channels[c].end(), channels[c], channels[c] + frames);
            return {};
          }};
}

FrameSink sink_into(WavWriter& writer) {
  return {writer.channels(),
          [&writer](const double* const* channels, int frames) { return writer.write(channels, frames); }};
}

Result<Health> run_offline(Guarded& processor, const OfflineJob& job) {
  if (auto status = check(job); !status) return tl::unexpected(status.error());
  if (auto status = processor.prepare(format_of(job)); !status) return tl::unexpected(status.error());
  HealthMeter meter;
  if (auto status = run_blocks(processor, job, meter); !status) return tl::unexpected(status.error());
  return meter.read();
}

Result<Samples> render(Guarded& processor, const Samples& input, int out_channels,
                       std::vector<int> block_frames) {
  Samples output{input.sample_rate, std::vector<std::vector<double>>(index(out_channels))};
  OfflineJob job;
  job.sample_rate = input.sample_rate;
  job.in_channels = static_cast<int>(input.channels.size());
  job.out_channels = out_channels;
  job.frames = input.frames();
  job.block_frames = std::move(block_frames);
  job.source = source_of(input);
  job.sink = sink_into(output);
  if (auto health = run_offline(processor, job); !health) return tl::unexpected(health.error());
  return output;
}

Result<std::vector<Device>> OfflineBackend::devices() {
  Device device;
  device.id = kDeviceId;
  device.name = "files and silence";
  device.in_channels = device.out_channels = kMostChannels;
  device.default_rate = job_.sample_rate;
  device.is_default = true;
  return std::vector<Device>{device};
}

Result<std::unique_ptr<Stream>> OfflineBackend::open(const StreamRequest& request, Guarded& processor) {
  if (!request.device.empty() && request.device != kDeviceId)
    return fail(Errc::UnknownName, "", fmt::format("there is no device '{}'", request.device),
                fmt::format("the only one here is '{}'", kDeviceId));
  OfflineJob job = job_;
  job.sample_rate = request.sample_rate.value_or(job.sample_rate);
  job.in_channels = request.in_channels;
  job.out_channels = request.out_channels;
  if (request.block_frames) job.block_frames = {*request.block_frames};
  if (auto status = check(job); !status) return tl::unexpected(status.error());
  if (auto status = processor.prepare(format_of(job)); !status) return tl::unexpected(status.error());
  return std::make_unique<OfflineStream>(std::move(job), processor);
}

}  // namespace tactus
