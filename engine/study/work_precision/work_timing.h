#pragma once

#include <memory>
#include <vector>

#include "engine/scene/build_scene.h"
#include "engine/scene/closed_loop.h"
#include "engine/scene/play_scene.h"

namespace tactus {

/// Times a scene's plant alone, its schedule in blocks of 64 frames: what the instrument gave out was
/// recorded and is played back to it, and nothing is recorded, converted or guarded.
class PlantTimer {
 public:
  /// [control] `recording` of the same scene, built in the same way; it may go.
  PlantTimer(BuiltScene built, const SceneSpec& scene, const SceneRecording& recording);
  ~PlantTimer();
  PlantTimer(PlantTimer&&) noexcept;

  /// [control] Runs it once more from the start, all of it or as much as takes about 0.3 s, a short one over
  /// and over for 3 ms, and keeps what a frame took.
  void run();
  /// [control] Median of the runs. [ns]
  double ns_per_frame() const;

 private:
  class Replay;

  std::unique_ptr<BuiltScene> built_;
  std::unique_ptr<Replay> replay_;
  std::unique_ptr<ClosedLoop> loop_;
  Hertz rate_;
  int frames_;
  std::vector<double> runs_ns_;
};

}  // namespace tactus
