#pragma once
// Thread: [control]

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/target.h"
#include "apps/play/live/judge_world.h"
#include "apps/play/play_report.h"
#include "backends/take/take.h"
#include "engine/graph/plan/compile.h"
#include "engine/guard/guarded.h"
#include "engine/rig/rig.h"
#include "engine/runtime/player.h"
#include "engine/scene/energy_watch.h"
#include "engine/scene/network_report.h"

namespace tactus::app {

/// The files of a performer, read again.
struct Edit {
  std::vector<std::filesystem::path> files;  ///< that were read; empty: not known
  std::vector<Error> errors;                 ///< why they cannot be played
  std::string warning;                       ///< or empty
  /// [control, while it plays] Replaces what plays. The guard that is given, which is around the processor of
  /// the performer, first gets the feedback paths that the edit adds. Throws a CommandError; the previous
  /// version then keeps playing.
  std::function<void(Guarded&)> take_over;
};

/// How long networks are timed after a session.
inline constexpr Seconds kTimingDuration = 50_ms;

/// What a live session plays: an instrument, or an instrument in its simulated world.
class Performer {
 public:
  virtual ~Performer() = default;

  std::string name;
  std::vector<std::filesystem::path> files;  ///< that it was read from
  std::vector<std::string> inputs, outputs;  ///< channels of `processor`
  std::vector<GuardedChannel> guards;        ///< what is connected to each output
  std::vector<int> in_map, out_map;          ///< channels of the card, from 0 on; empty: the first ones
  std::string input_signals;                 ///< as World::inputs

  /// What a Guarded is put around.
  virtual BlockProcessor& processor() = 0;
  /// Whose controls, faults and edits are shown.
  virtual Player& instrument() = 0;
  /// [control] The simulated world around it; nullptr: there is none.
  virtual Player* plant() { return nullptr; }
  /// [any, one thread; while it plays] Reads and compiles its files again. What plays is not touched.
  virtual Edit read_edit() = 0;
  /// Puts its files and what the rig does to its inputs into the header of a take.
  virtual void describe(TakeHeader&) const {}
  /// [control & stopped] The energy that passed the ports of a scene.
  virtual std::vector<PortEnergy> ports() const { return {}; }
  /// [control & stopped, after it has played] The networks; runs for a moment, in blocks of `block` frames,
  /// to time them.
  virtual std::vector<NetworkReport> networks(int /*block*/) { return {}; }
  /// [any] It can be struck by hand.
  virtual bool can_strike() const { return false; }
  /// [control] Signals of the plant that can be set by hand.
  virtual std::vector<std::string> gestures() { return {}; }
  /// [any] The system delay of the simulated world; nothing: there is none.
  virtual std::optional<Seconds> world_delay() const { return std::nullopt; }
  /// [any, one thread; while it plays] Whether the world is stable with this delay and these values of
  /// controls; takes seconds. `go_on` is asked again and again: false ends it with no verdict.
  virtual WorldVerdict judge(Seconds /*delay*/, const std::map<std::string, ControlValue>& /*controls*/,
                             const std::function<bool()>& /*go_on*/) const {
    return {};
  }
  /// [control, while it plays] False: there is none, or no room.
  virtual bool set_gesture(int /*gesture*/, double /*value*/) { return false; }
  /// [control, while it plays] Strikes once, where the scene can be played by hand.
  virtual bool strike() { return false; }
};

struct PerformerSetup {
  Target target;
  std::string in{};  ///< what the inputs of a simulated instrument receive: see load_world
  Hertz rate = 48_kHz;
  std::optional<Seconds> delay{};  ///< of the card, as far as it is known; of a scene: instead of its own
  std::map<std::string, ControlValue> controls{};
  GuardOptions guard{};
  std::optional<Rig> rig{};
  int padding_frames = 0;  ///< added to the card's own delay
  int speakers = 2;        ///< channels for the monitor output of a scene
};

/// An instrument on a sound card. Without a rig it is unknown what is connected: outputs of kind "audio" are
/// then guarded as drives too, but without a slew limit. Throws a CommandError.
std::unique_ptr<Performer> make_instrument(PerformerSetup setup);

/// A scene or an instrument without its plant, simulated in real time: the monitor output goes to the
/// speakers, where there is none the drives, and the sensors of a scene without drives. Edits of its
/// instrument and of its plant take effect while it plays. Throws a CommandError.
std::unique_ptr<Performer> make_world(PerformerSetup setup);

}  // namespace tactus::app
