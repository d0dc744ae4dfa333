#pragma once
// Thread: [control]

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/node_type.h"
#include "engine/graph/plan/compile.h"
#include "engine/runtime/player.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

struct SceneOptions {
  std::optional<Seconds> delay;  ///< instead of the scene's
  std::optional<Hertz> rate;     ///< instead of the scene's
  std::map<std::string, ControlValue>
      set;  ///< "strength" of the instrument, "plant.gain" of another part; SI
  /// A person strikes: the world gets a control `strike`, from 0 to 1, which every control of this name of a
  /// part follows, overriding the scene.
  bool by_hand = false;
  bool vectorise = true;  ///< as CompileOptions::vectorise
};

/// A signal that is recorded while a scene plays.
struct SceneTap {
  std::string name;  ///< "plant.stick", "instrument.hit"
  Dimension dimension;
};

struct SceneTaps {
  int delay_frames = 0;
  std::vector<SceneTap> plant_taps;       ///< every output of every part, in the order of Player::tap
  std::vector<SceneTap> instrument_taps;  ///< triggers of the instrument ("instrument.hit") and their levels
};

/// A scene turned into two schedules: the instrument as it would run on a card, and the world around it: the
/// plant, every other part, the gestures, and the wires from them to the instrument's inputs.
struct CompiledScene : SceneTaps {
  std::unique_ptr<Plan> instrument, plant;
  std::vector<JournalEntry> journal;  ///< what gestures do to the instrument's controls
};

/// The same as two engines, ready to be prepared.
struct BuiltScene : SceneTaps {
  explicit BuiltScene(CompiledScene compiled);

  std::unique_ptr<Player> instrument, plant;
};

/// [control] All errors of its text, of the wiring, of both graphs and of the measures, in file order.
Checked<CompiledScene> compile_scene(const LoadedScene& loaded, const NodeTable& table,
                                     const SceneOptions& options = {});
/// [control] The same as engines.
Checked<BuiltScene> build_scene(const LoadedScene& loaded, const NodeTable& table,
                                const SceneOptions& options = {});

/// Names of the triggers of a graph that are events for a person ("hit"), each followed by its level if its
/// type has one
/// ("hit.level").
std::vector<std::string> event_taps(const GraphSpec& graph, const NodeTable& table);

}  // namespace tactus
