#include "apps/latency/profile_file.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <fstream>

#include "engine/dsp/delays/taps_at_rate.h"
#include "engine/scene/file/path_file.h"

namespace tactus::app {
namespace {

std::string today() {
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%d}", fmt::gmtime(now));
}

std::string found(const Calibration& calibration, const std::string& device) {
  const auto& profile = calibration.profile;
  auto text = fmt::format(
      "Measured {} on {} at {:g} kHz: known from {:.0f} Hz to {:.0f} Hz, arrives after {:.3f} ms, {}",
      today(), device, profile.sample_rate.value / 1e3, profile.low.value, profile.high.value,
      1e3 * calibration.arrival_frames / profile.sample_rate.value,
      calibration.polarity > 0 ? "not inverted" : "inverted");
  if (const auto& resonance = calibration.resonance)
    text += fmt::format(", resonance {:.1f} Hz, Q {:.2f}", resonance->frequency_hz, resonance->q);
  return text + ".";
}

}  // namespace

Status write_profile(const std::filesystem::path& file, const Calibration& calibration,
                     const std::string& device) {
  const auto& profile = calibration.profile;
  std::ofstream text{file};
  text << to_text(PathFile{file.stem().string(), found(calibration, device), "tactus latency calibrate",
                           profile.sample_rate, profile.taps});
  text.close();
  if (text) return {};
  return fail(Errc::BadFile, file.string(), "cannot be written",
              "choose a folder that exists and can be written");
}

Result<PathProfile> read_profile(const std::filesystem::path& file, Hertz sample_rate) {
  const auto path = load_path(file);
  if (!path) return tl::unexpected(path.error().front());
  PathProfile profile;
  profile.sample_rate = sample_rate;
  profile.taps = taps_at_rate(path->taps, path->rate, sample_rate);
  return profile;
}

}  // namespace tactus::app
