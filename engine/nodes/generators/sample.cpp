#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <system_error>

#include "engine/nodes/generators/recording.h"
#include "engine/nodes/generators/sample_kernel.h"
#include "engine/nodes/kernel_node.h"

namespace tactus {
namespace {

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
    return fail(Errc::BadFile, {}, "'" + path + "' is not a regular file", "name a WAV, AIFF or FLAC file");
  SF_INFO info{};
  const std::unique_ptr<SNDFILE, int (*)(SNDFILE*)> file{sf_open(path.c_str(), SFM_READ, &info), sf_close};
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
                "use a shorter recording");
  if (!std::all_of(recording.samples.begin(), recording.samples.end(),
                   [](double x) { return std::isfinite(x); }))
    return fail(Errc::BadFile, {}, "'" + path + "' contains non-finite values", "export the file again");
  return recording;
}

namespace {

constexpr double kMaxSpeed = 1000;

Result<std::unique_ptr<Node>> make_sample(const NodeSetup& setup) {
  auto recording =
      read_recording(setup.setting("file").text, static_cast<int>(setup.setting("channel").number));
  if (!recording) return tl::unexpected<Error>(recording.error());
  const double samples_per_frame = recording->sample_rate / setup.sample_rate;
  const bool cubic = setup.setting("interpolation").text == "cubic";
  return make_step_node<3, tactus_sample>([samples = std::move(recording->samples), samples_per_frame, cubic](
                                              tactus_sample& player, double trigger, double speed,
                                              double level) {
    if (tactus_rise_step(&player.rise, trigger) != 0) tactus_sample_start(&player);
    const double increment = std::clamp(speed, 0.0, kMaxSpeed) * samples_per_frame;
    return level *
           tactus_sample_read(&player, samples.data(), static_cast<int>(samples.size()), increment, cubic);
  });
}

}  // namespace

NodeType sample_type() {
  return {
      .name = "sample",
      .summary = "Plays a channel of a sound file from its start at each trigger; silent before and after.",
      .equation = "out[n] = level * s(p[n]); p = 0 at a trigger, p[n+1] = p[n] + speed[n] * file_rate / rate",
      .source = "Moore, Elements of Computer Music, 1990; cubic: Catmull & Rom, 1974",
      .example = "thud = { type = \"sample\", file = \"thud.wav\", trigger = \"hit\" }",
      .inputs = {{"trigger", "", "starts playback of the file; a constant 1 starts it at the first frame"},
                 {"speed", "", "playback speed; 1: as recorded; not band-limited above 1", 1, 0, kMaxSpeed},
                 {"level", "any", "output level for full scale in the file", 1}},
      .outputs = {{"out", "=level", "the played recording"}},
      .silencers = {{"trigger"}, {"level"}},
      .settings = {required({"file", Setting::Kind::File,
                             "WAV, AIFF or FLAC file; played at its own sample rate"}),
                   within(
                       1, 1024,
                       {"channel", Setting::Kind::Integer, "channel of the file, counted from 1", {}, "1"}),
                   choice("interpolation", "interpolation between two samples of the file",
                          {"linear", "cubic"}, "cubic")},
      .make = make_sample,
  };
}

}  // namespace tactus
