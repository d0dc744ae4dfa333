#include "apps/latency/latency_files.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>

#include "apps/render/render.h"
#include "backends/wav_file.h"
#include "engine/dsp/delays/resample.h"
#include "engine/scene/file/path_file.h"

namespace tactus::app {
namespace {

Status fit(const Samples& samples, const std::string& path) {
  if (samples.frames() == 0) return fail(Errc::BadFile, path, "it contains no samples", "record it again");
  if (!(samples.sample_rate >= 1_kHz && samples.sample_rate.value <= 1e6))
    return fail(Errc::BadFile, path,
                fmt::format("its header states a sample rate of {:g} Hz, which no sound card supports",
                            samples.sample_rate.value),
                "give the actual rate with --rate");
  for (const auto& channel : samples.channels)
    if (!std::all_of(channel.begin(), channel.end(), [](double sample) { return std::isfinite(sample); }))
      return fail(Errc::BadFile, path, "some of its samples are non-finite", "record it again");
  return {};
}

Result<Samples> read(const std::string& path, const std::optional<Hertz>& rate) {
  auto samples = read_wav(path);
  if (!samples) return samples;
  if (rate) samples->sample_rate = *rate;
  if (auto status = fit(*samples, path); !status) return tl::unexpected(status.error());
  return samples;
}

/// Which of the channels that were captured; `first`: the channel of the file that they begin with, from 1.
Result<int> captured_channel(const CaptureFiles& files, int first, int channels) {
  const int asked = files.channel.value_or(first);
  if (asked >= first && asked < first + channels) return asked - first;
  return fail(Errc::BadArgument, "--channel",
              first == 2 && asked == 1 ? "without --probe, channel 1 must be the played signal"
                                       : fmt::format("'{}' has no channel {}", files.capture, asked),
              channels == 1 ? fmt::format("it has only channel {}", first)
                            : fmt::format("it has channels {} to {}", first, first + channels - 1));
}

/// The probe at the rate of what was captured.
Samples at_rate(Samples probe, const Samples& captured, Capture& capture) {
  if (probe.sample_rate == captured.sample_rate) return probe;
  capture.note = fmt::format(
      "the probe file is at {:g} Hz and the recording at {:g} Hz: the probe was resampled; if only a header "
      "is wrong, give --rate",
      probe.sample_rate.value, captured.sample_rate.value);
  return resample(probe, captured.sample_rate);
}

Result<Capture> joined(const CaptureFiles& files, Samples captured) {
  Capture capture;
  auto probe = read(files.probe, files.rate);
  if (!probe) return tl::unexpected(probe.error());
  auto played = at_rate(std::move(*probe), captured, capture);
  const auto channel = captured_channel(files, 1, static_cast<int>(captured.channels.size()));
  if (!channel) return tl::unexpected(channel.error());
  capture.channel = *channel;
  auto& first = played.channels.front();
  first.resize(static_cast<std::size_t>(std::max(captured.frames(), played.frames())));
  capture.recording = {captured.sample_rate, std::move(first), std::move(captured.channels)};
  return capture;
}

Result<Capture> cut(const CaptureFiles& files, Samples both) {
  if (both.channels.size() < 2)
    return fail(Errc::BadFile, files.capture, "it has one channel, and no probe file is given",
                "give the file that was played as --probe");
  const auto channel = captured_channel(files, 2, static_cast<int>(both.channels.size()) - 1);
  if (!channel) return tl::unexpected(channel.error());
  auto played = std::move(both.channels.front());
  both.channels.erase(both.channels.begin());
  return Capture{{both.sample_rate, std::move(played), std::move(both.channels)}, *channel, ""};
}

std::string description_of(const Calibration& calibration, const std::string& device) {
  const auto& profile = calibration.profile;
  auto text = fmt::format(
      "Measured {} on {} at {:g} kHz: valid from {:.0f} Hz to {:.0f} Hz, arrives after {:.3f} ms, {}",
      fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::time(nullptr))), device, profile.sample_rate.value / 1e3,
      profile.low.value, profile.high.value, 1e3 * calibration.arrival_frames / profile.sample_rate.value,
      calibration.polarity > 0 ? "not inverted" : "inverted");
  if (const auto& resonance = calibration.resonance)
    text += fmt::format(", resonance {:.1f} Hz, Q {:.2f}", resonance->frequency_hz, resonance->q);
  return text + ".";
}

}  // namespace

Result<Capture> read_capture(const CaptureFiles& files) {
  auto samples = read(files.capture, files.rate);
  if (!samples) return tl::unexpected(samples.error());
  return files.probe.empty() ? cut(files, std::move(*samples)) : joined(files, std::move(*samples));
}

Status write_recording(const std::string& path, const LoopRecording& recording) {
  Samples samples{recording.sample_rate, {recording.played}};
  samples.channels.insert(samples.channels.end(), recording.captured.begin(), recording.captured.end());
  return write_wav(path, samples);
}

Status write_profile(const std::filesystem::path& file, const Calibration& calibration,
                     const std::string& device) {
  const auto& profile = calibration.profile;
  std::ofstream text{file};
  text << to_text(PathFile{file.stem().string(), description_of(calibration, device),
                           "tactus latency calibrate", profile.sample_rate, profile.taps});
  text.close();
  if (text) return {};
  return fail(Errc::BadFile, file.string(), "cannot be written", "choose an existing, writable folder");
}

Result<PathProfile> read_profile(const std::filesystem::path& file, Hertz sample_rate) {
  const auto path = read_path(load_graph_leniently(file));
  if (!path) return tl::unexpected(path.error().front());
  PathProfile profile;
  profile.sample_rate = sample_rate;
  profile.taps = taps_at_rate(path->taps, path->rate, sample_rate);
  return profile;
}

}  // namespace tactus::app
