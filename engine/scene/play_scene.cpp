#include "engine/scene/play_scene.h"

#include <algorithm>
#include <chrono>

#include "engine/core/named.h"
#include "engine/scene/closed_loop.h"

namespace tactus {
namespace {

/// Copies what goes by into the recording, which has its names: sensors, drives, then the taps of both
/// engines.
class Recorder {
 public:
  Recorder(SceneRecording& recording, BuiltScene& built, std::size_t frames)
      : recording_(recording), built_(built) {
    for (const auto& name : recording.inputs) add("instrument." + name, {}, frames);
    for (const auto& name : recording.outputs) add("instrument." + name, {}, frames);
    for (const auto& tap : built.plant_taps) add(tap.name, tap.dimension, frames);
    for (const auto& tap : built.instrument_taps) add(tap.name, tap.dimension, frames);
  }

  void take(const ClosedLoop::Block& io) {
    std::size_t next = 0;
    for (const auto* sensor : io.sensors) append(next++, sensor, io.frames);
    for (const auto* drive : io.drives) append(next++, drive, io.frames);
    for (int t = 0; t < built_.plant->tap_count(); ++t) append(next++, built_.plant->tap(t), io.frames);
    for (int t = 0; t < built_.instrument->tap_count(); ++t)
      append(next++, built_.instrument->tap(t), io.frames);
  }

 private:
  void add(std::string name, Dimension dimension, std::size_t frames) {
    recording_.signals.push_back({std::move(name), dimension, {}});
    recording_.signals.back().samples.reserve(frames);
  }
  void append(std::size_t signal, const double* samples, int frames) {
    auto& to = recording_.signals[signal].samples;
    to.insert(to.end(), samples, samples + frames);
  }

  SceneRecording& recording_;
  BuiltScene& built_;
};

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
  const auto frames = static_cast<int>(frames_in(scene.duration, recording.sample_rate));
  recording.inputs = built.instrument->plan().input_names;
  recording.outputs = output_names(built.instrument->plan());
  recording.sounds = sound_names(built.instrument->plan());
  Recorder recorder{recording, built, static_cast<std::size_t>(frames)};
  PortWatches ports{scene, built.plant_taps};
  const auto started = std::chrono::steady_clock::now();
  const int part = std::max(block, frames / 100);
  for (int done = 0; done < frames; done += part) {
    loop.run(std::min(part, frames - done), [&](const ClosedLoop::Block& io) {
      recorder.take(io);
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
