#include "apps/play/play_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "apps/cli/console.h"
#include "engine/scene/measures/notes/pitch_track.h"
#include "engine/study/scene_plot.h"

namespace tactus::app {
namespace {

using Signals = std::vector<const RecordedSignal*>;

std::string slug(const std::string& name) {
  std::string text;
  for (const unsigned char c : name) text += std::isalnum(c) != 0 ? static_cast<char>(c) : '_';
  return text.empty() ? "scene" : text;
}

Result<std::pair<double, double>> shown_times(const std::vector<std::string>& show,
                                              const SceneRecording& recording) {
  const double shown = melody_of(recording) ? recording.seconds() : std::min(1.0, recording.seconds());
  if (show.empty()) return std::pair{0.0, shown};
  const auto from = parse_option(show[0], "s", "show");
  const auto to = parse_option(show[1], "s", "show");
  if (!from) return tl::unexpected(from.error());
  if (!to) return tl::unexpected(to.error());
  if (*from >= *to || *from >= recording.seconds())
    return fail(Errc::OutOfRange, "--show", "shows nothing of this scene",
                "give two rising times within its duration");
  return std::pair{*from, *to};
}

Signals of_instrument(const SceneRecording& recording, const std::vector<std::string>& names) {
  Signals signals;
  for (const auto& name : names) signals.push_back(recording.find("instrument." + name));
  return signals;
}

Signals motion_in(const SceneRecording& recording) {
  Signals signals;
  for (const auto& signal : recording.signals)
    if (!signal.name.starts_with("instrument.") && !signal.dimension.plain()) signals.push_back(&signal);
  return signals;
}

std::string named(const Signals& signals) {
  std::string names;
  for (const auto* signal : signals) {
    names += (names.empty() ? "" : ", ") + signal->name.substr(signal->name.find('.') + 1);
    if (!signal->dimension.plain()) names += " [" + to_string(signal->dimension) + "]";
  }
  return names;
}

Status write_sound(const std::string& path, const Signals& signals, Hertz rate,
                   std::vector<std::string>& written) {
  if (signals.empty()) return {};
  Samples samples;
  samples.sample_rate = rate;
  for (const auto* signal : signals) samples.channels.push_back(signal->samples);
  written.push_back(path + "  " + named(signals));
  return write_wav(path, samples);
}

}  // namespace

std::string base_of(const std::string& folder, const PlayedScene& played) {
  return (std::filesystem::path{folder} / slug(played.scene.name)).string();
}

Result<std::vector<std::string>> write_files(const std::string& folder, const std::vector<std::string>& show,
                                             const PlayedScene& played) {
  const auto& recording = played.recording;
  const auto times = shown_times(show, recording);
  if (!times) return tl::unexpected(times.error());
  std::error_code ignored;
  std::filesystem::create_directories(folder, ignored);
  const auto base = base_of(folder, played);
  std::vector<std::string> written;
  const std::pair<const char*, Signals> sounds[] = {
      {"_sound.wav", of_instrument(recording, recording.sounds)},
      {"_drives.wav", of_instrument(recording, drive_names(recording))},
      {"_sensors.wav", of_instrument(recording, recording.inputs)},
      {"_motion.wav", motion_in(recording)}};
  for (const auto& [suffix, signals] : sounds)
    if (auto status = write_sound(base + suffix, signals, recording.sample_rate, written); !status)
      return tl::unexpected(status.error());
  const auto picture = base + ".svg";
  if (auto status = write_svg(picture, {scene_plot(played.scene, recording, times->first, times->second)});
      !status)
    return tl::unexpected(status.error());
  written.push_back(picture + fmt::format("  the plot, {:g} s to {:g} s", times->first, times->second));
  return written;
}

}  // namespace tactus::app
