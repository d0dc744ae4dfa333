#include "engine/nodes/generators/sound_file.h"

#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <system_error>

namespace tactus {
namespace {

struct CloseFile {
  void operator()(SNDFILE* file) const { sf_close(file); }
};

// 512 MB, which is what a whole graph may keep.
constexpr std::size_t kSoundFileMostFrames = 64 << 20;

/// Reads to the end of the data, or a little beyond kSoundFileMostFrames: the length in a damaged header
/// cannot be trusted.
std::vector<double> read_channel(SNDFILE* file, int channels, int channel) {
  constexpr sf_count_t kFrames = 4096;
  std::vector<double> interleaved(static_cast<std::size_t>(kFrames * channels));
  std::vector<double> samples;
  while (const auto frames = sf_readf_double(file, interleaved.data(), kFrames)) {
    if (frames < 0 || samples.size() > kSoundFileMostFrames) break;
    for (sf_count_t i = 0; i < frames; ++i)
      samples.push_back(interleaved[static_cast<std::size_t>(i * channels + channel - 1)]);
  }
  return samples;
}

}  // namespace

Result<Recording> read_recording(const std::string& path, int channel) {
  std::error_code error;
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error))
    return fail(Errc::BadFile, {}, "'" + path + "' is no ordinary file", "name a WAV, AIFF or FLAC file");
  SF_INFO info{};
  const std::unique_ptr<SNDFILE, CloseFile> file{sf_open(path.c_str(), SFM_READ, &info)};
  if (!file)
    return fail(Errc::BadFile, {}, "cannot read '" + path + "': " + sf_strerror(nullptr),
                "name a WAV, AIFF or FLAC file, relative to the graph file");
  if (channel > info.channels)
    return fail(
        Errc::OutOfRange, {},
        "'" + path + "' has " + std::to_string(info.channels) + " channels, not " + std::to_string(channel),
        "choose a smaller 'channel'");
  Recording recording{read_channel(file.get(), info.channels, channel),
                      Hertz{static_cast<double>(info.samplerate)}};
  if (recording.samples.size() > kSoundFileMostFrames)
    return fail(Errc::OutOfRange, {},
                "'" + path + "' is longer than " + std::to_string(kSoundFileMostFrames) + " frames",
                "take a shorter recording");
  if (!std::all_of(recording.samples.begin(), recording.samples.end(),
                   [](double x) { return std::isfinite(x); }))
    return fail(Errc::BadFile, {}, "'" + path + "' holds values that are not finite",
                "export the file again");
  return recording;
}

}  // namespace tactus
