#include "apps/latency/keep_delay.h"

#include <fmt/chrono.h>

#include <chrono>

#include "apps/play/save_rig.h"

namespace tactus::app {
namespace {

Seconds in_seconds(double frames, const StreamGranted& granted) {
  return Seconds{frames / granted.format.sample_rate.value};
}

std::string now() {
  const auto seconds = std::chrono::time_point_cast<std::chrono::seconds>(std::chrono::system_clock::now());
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(seconds)));
}

}  // namespace

DelayKey key_of(const StreamGranted& granted) {
  return {granted.input_device.empty() ? granted.device : granted.input_device, granted.device,
          granted.format.sample_rate, granted.block_frames, granted.periods};
}

Status keep_on_machine(const Measurement& measurement) {
  const auto& granted = measurement.openings.front().granted;
  auto store = MeasuredDelays::load();
  return store.keep({key_of(granted), in_seconds(measurement.delay_frames, granted),
                     in_seconds(measurement.spread_frames, granted), now()});
}

Status keep_in_rig(const Measurement& measurement, Rig rig, const std::filesystem::path& file) {
  const auto& granted = measurement.openings.front().granted;
  auto& device = rig.device;
  rig.measured_delay = in_seconds(measurement.delay_frames, granted);
  device.rate = granted.format.sample_rate;
  if (granted.block_frames > 0) device.block = granted.block_frames;
  if (granted.periods > 0) device.periods = granted.periods;
  return replace_rig(rig, file);
}

}  // namespace tactus::app
