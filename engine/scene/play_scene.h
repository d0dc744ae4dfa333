#pragma once
// Thread: [control]

#include <functional>
#include <string>
#include <vector>

#include "engine/guard/guarded.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/energy_watch.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/scene/guard_report.h"
#include "engine/scene/network_report.h"

namespace tactus {

/// One signal of a scene over its whole duration.
struct RecordedSignal {
  std::string name;  ///< "plant.stick", "instrument.microphone", "instrument.woofer", "instrument.hit.hit"
  Dimension dimension;
  std::vector<double> samples;
};

/// All that happened while a scene played.
struct SceneRecording {
  Hertz sample_rate;
  int delay_frames = 0;
  std::vector<RecordedSignal> signals;
  std::vector<std::string> inputs, outputs;  ///< of the instrument, in order
  std::vector<std::string> sounds;           ///< of its outputs, those for the ears (see sound_names)
  std::vector<Role> roles;                   ///< of the scene
  std::optional<Playability> playability;    ///< likewise
  std::vector<FaultCount> faults;            ///< of both engines
  GuardReport guard;                         ///< what the drive guards had to do
  std::vector<PortEnergy> ports;             ///< what went through the ports
  std::int64_t bad_inputs = 0;
  double run_seconds = 0;  ///< wall-clock time

  /// nullptr if nothing of that name was recorded.
  const RecordedSignal* find(std::string_view name) const;
  double seconds() const;
};

/// [any] The outputs of the instrument that are not `sounds`.
std::vector<std::string> drive_names(const SceneRecording& recording);

/// [control] Plays a built scene from start to end in blocks of `block` frames. `progress` receives the share
/// done, `times` each block.
Result<SceneRecording> play_scene(const SceneSpec& scene, BuiltScene& built, int block,
                                  const std::function<void(double)>& progress = {},
                                  SceneTimes* times = nullptr);

}  // namespace tactus
