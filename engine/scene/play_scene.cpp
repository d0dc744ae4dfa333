#include "engine/scene/play_scene.h"

#include <algorithm>
#include <chrono>

#include "engine/core/named.h"
#include "engine/core/port_name.h"
#include "engine/scene/closed_loop.h"

namespace tactus {
namespace {

/// Of an input of the instrument, or of a lane of it: "fingers[2]".
Dimension unit_of_input(const SceneSpec& scene, const std::string& name) {
  const auto* part = scene.part("instrument");
  if (part == nullptr || part->graph == nullptr) return {};
  const auto* input = find_named(part->graph->inputs, port_of(name));
  return input == nullptr ? Dimension{} : input->dimension;
}

/// Sensors, drives, then the taps of both engines.
void name_signals(SceneRecording& recording, const SceneSpec& scene, const BuiltScene& built,
                  std::size_t frames) {
  for (const auto& name : recording.inputs)
    recording.signals.push_back({"instrument." + name, unit_of_input(scene, name), {}});
  for (const auto& name : recording.outputs) recording.signals.push_back({"instrument." + name, {}, {}});
  for (const auto* taps : {&built.plant_taps, &built.instrument_taps})
    for (const auto& tap : *taps) recording.signals.push_back({tap.name, tap.dimension, {}});
  for (auto& signal : recording.signals) signal.samples.reserve(frames);
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
                                  const std::function<void(double)>& progress, SceneTimes* times) {
  SceneRecording recording;
  recording.sample_rate = built.instrument->plan().sample_rate;
  recording.delay_frames = built.delay_frames;
  recording.roles = scene.roles;
  recording.playability = scene.playability;
  Guarded guarded{*built.instrument, guarded_channels(built.instrument->plan(), scene.drives)};
  ClosedLoop loop{guarded, *built.plant, built.instrument->out_channels(), built.delay_frames,
                  scene.converters};
  if (loop.has_units()) guarded.disable_sensor_watch();
  if (auto status = loop.prepare(recording.sample_rate, block); !status)
    return tl::unexpected(status.error());
  guarded.skip_soft_start();
  const auto frames = static_cast<int>(frames_in(scene.duration, recording.sample_rate));
  recording.inputs = built.instrument->plan().input_names;
  recording.outputs = output_names(built.instrument->plan());
  recording.sounds = sound_names(built.instrument->plan(), scene.roles);
  name_signals(recording, scene, built, static_cast<std::size_t>(frames));
  PortWatches ports{scene, built.plant_taps};
  const auto started = std::chrono::steady_clock::now();
  const int part = std::max(block, frames / 100);
  for (int done = 0; done < frames; done += part) {
    loop.run(std::min(part, frames - done), [&](const ClosedLoop::Block& io) {
      record(recording, built, io);
      ports.take(*built.plant, io.frames);
      if (times != nullptr) times->add(io.frames);
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
