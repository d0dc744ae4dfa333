#pragma once
// Thread: [control]

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/guard_options.h"
#include "backends/take/take.h"
#include "engine/graph/plan/compile.h"
#include "engine/guard/guarded.h"
#include "engine/rig/rig.h"
#include "engine/runtime/player.h"
#include "engine/scene/energy_watch.h"

namespace tactus::app {

/// What sounds in a live session: an instrument, or an instrument in its simulated world.
class Performer {
 public:
  virtual ~Performer() = default;

  virtual const std::string& name() const = 0;
  /// What a Guarded is put around.
  virtual BlockProcessor& processor() = 0;
  /// Whose controls, faults and edits are shown.
  virtual Player& instrument() = 0;
  virtual const Player& instrument() const = 0;
  /// Channels of `processor`, and what is connected to each output.
  virtual std::vector<std::string> inputs() const = 0;
  virtual std::vector<std::string> outputs() const = 0;
  virtual std::vector<GuardedChannel> guards() const = 0;
  /// Channels of the card, from 0 on; empty: the first ones.
  virtual std::vector<int> in_map() const { return {}; }
  virtual std::vector<int> out_map() const { return {}; }
  /// The files that it was read from.
  virtual std::vector<std::filesystem::path> files() const = 0;
  /// [control, while it plays] Reads its files again and puts what they say in the place of what sounds.
  /// Errors: what is wrong with them; the old version then plays on.
  virtual Checked<void> edit() = 0;
  /// Can a take of it be played again? Its files and what the rig does to its inputs go into `header` then.
  virtual bool describe(TakeHeader&) const { return false; }
  /// [control & stopped] What went through the ports of a scene, as far as one was played.
  virtual std::vector<PortEnergy> ports() const { return {}; }
  /// [control, while it plays] Strikes once, where there is something to strike.
  virtual bool strike() { return false; }
};

/// An instrument on a sound card. Without a rig it is unknown what is connected: all outputs, sound too,
/// then have the guard of a drive with `drives`.
struct InstrumentSetup {
  std::filesystem::path file, root;
  Hertz rate = 48_kHz;
  Seconds delay;           ///< system delay, padding included, as far as it is known
  int padding_frames = 0;  ///< to be added to the card's own delay
  std::map<std::string, ControlValue> controls;
  std::optional<Rig> rig;
  GuardOptions guard;
};
Checked<std::unique_ptr<Performer>> make_instrument(InstrumentSetup setup);

/// A scene, its simulated world run in real time: the instrument's audio outputs go to `speakers` channels,
/// the sensors where it has none. Edits of what both sides read are followed.
struct WorldSetup {
  std::filesystem::path file, root;
  Hertz rate = 48_kHz;
  std::optional<Seconds> delay;  ///< instead of the scene's
  std::map<std::string, ControlValue> set;
  GuardOptions guard;
  int speakers = 2;
};
Checked<std::unique_ptr<Performer>> make_world(WorldSetup setup);

/// The files of a graph and its parts.
std::vector<std::filesystem::path> files_of(const GraphSpec& graph);

}  // namespace tactus::app
