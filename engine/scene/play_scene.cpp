#include "engine/scene/play_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "engine/core/named.h"
#include "engine/scene/closed_loop.h"

namespace tactus {
namespace {

/// Sensors, drives, then the taps of both engines. Errors: OutOfRange if they do not fit.
Status name_signals(SceneRecording& recording, const BuiltScene& built, double frames) {
  for (const auto* names : {&recording.inputs, &recording.outputs})
    for (const auto& name : *names) recording.signals.push_back({"instrument." + name, {}, {}});
  for (const auto* taps : {&built.plant_taps, &built.instrument_taps})
    for (const auto& tap : *taps) recording.signals.push_back({tap.name, tap.dimension, {}});
  const double bytes_per_frame = static_cast<double>(recording.signals.size() * sizeof(double));
  if (bytes_per_frame * frames > kMostRecordingBytes)
    return fail(
        Errc::OutOfRange, "",
        fmt::format("a run of {:g} s would keep {:.3g} GB of signals in memory; at most {:.3g} GB are "
                    "allowed",
                    frames / recording.sample_rate.value, bytes_per_frame * frames / 1e9,
                    kMostRecordingBytes / 1e9),
        fmt::format("choose a duration of at most {:.0f} s, or a lower sample rate",
                    std::floor(kMostRecordingBytes / bytes_per_frame / recording.sample_rate.value)));
  for (auto& signal : recording.signals) signal.samples.reserve(static_cast<std::size_t>(frames));
  return {};
}

void record(SceneRecording& recording, const BuiltScene& built, const ClosedLoop::Block& io) {
  std::vector<const double*> samples(io.sensors.begin(), io.sensors.end());
  samples.insert(samples.end(), io.drives.begin(), io.drives.end());
  for (const auto* engine : {built.plant.get(), built.instrument.get()})
    for (int t = 0; t < engine->tap_count(); ++t) samples.push_back(engine->tap(t));
  for (std::size_t s = 0; s < samples.size(); ++s) {
    auto& to = recording.signals[s].samples;
    to.insert(to.end(), samples[s], samples[s] + io.frames);
  }
}

void collect_faults(SceneRecording& recording, const Player& engine, const std::string& prefix) {
  for (auto fault : engine.faults()) {
    fault.path = prefix + fault.path;
    recording.faults.push_back(std::move(fault));
  }
  recording.bad_inputs += engine.bad_input_samples();
}

}  // namespace

const RecordedSignal* SceneRecording::find(std::string_view name) const { return find_named(signals, name); }

double SceneRecording::seconds() const {
  return signals.empty() ? 0 : static_cast<double>(signals.front().samples.size()) / sample_rate.value;
}

std::vector<std::string> drive_names(const SceneRecording& recording) {
  auto names = recording.outputs;
  std::erase_if(names, [&](const std::string& name) {
    return std::ranges::find(recording.sounds, name) != recording.sounds.end();
  });
  return names;
}

Result<SceneRecording> play_scene(const SceneSpec& scene, BuiltScene& built, int block,
                                  const std::function<void(double)>& progress) {
  SceneRecording recording;
  recording.sample_rate = built.instrument->plan().sample_rate;
  recording.delay_frames = built.delay_frames;
  recording.roles = scene.roles;
  recording.playability = scene.playability;
  Guarded guarded{*built.instrument, guarded_channels(built.instrument->plan(), scene.drives)};
  ClosedLoop loop{guarded, *built.plant, built.instrument->out_channels(), built.delay_frames,
                  scene.converters};
  if (auto status = loop.prepare(recording.sample_rate, block); !status)
    return tl::unexpected(status.error());
  guarded.skip_soft_start();
  recording.inputs = built.instrument->plan().input_names;
  recording.outputs = output_names(built.instrument->plan());
  recording.sounds = sound_names(built.instrument->plan(), scene.roles);
  if (auto status = name_signals(recording, built, frames_in(scene.duration, recording.sample_rate)); !status)
    return tl::unexpected(status.error());
  const auto frames = static_cast<int>(frames_in(scene.duration, recording.sample_rate));
  PortWatches ports{scene, built.plant_taps};
  const auto started = std::chrono::steady_clock::now();
  const int part = std::max(block, frames / 100);
  for (int done = 0; done < frames; done += part) {
    loop.run(std::min(part, frames - done), [&](const ClosedLoop::Block& io) {
      record(recording, built, io);
      ports.take(*built.plant, io.frames);
    });
    if (progress) progress(std::min(1.0, static_cast<double>(done + part) / frames));
  }
  recording.run_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  collect_faults(recording, *built.instrument, "instrument.");
  collect_faults(recording, *built.plant, "");
  recording.guard = report_of(guarded, built.instrument->plan(), scene.drives);
  recording.ports = ports.energies(recording.sample_rate);
  return recording;
}

}  // namespace tactus
