#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/dimension.h"
#include "engine/core/error.h"
#include "engine/graph/body_source.h"
#include "engine/rig/rig.h"
#include "engine/runtime/signal_scope.h"
#include "remote/picture.h"

// What clients of other programs and hosts (OSC and others) do with a running instrument.

namespace tactus {

/// A control as clients see it. Numbers are in its own unit, that of its `value` in the graph file: 15 for
/// "15 ms", -34 for "-34 dB".
struct RemoteControl {
  std::string name;
  int number = -1;        ///< by which orders name it; it stays the same after edits
  std::string unit_name;  ///< "ms", "dB"; "": a plain number
  Unit unit = {};
  double low = 0.0, high = 0.0;  ///< SI; may be infinite
  bool constant = false;         ///< it cannot be changed during playback
  double initial = 0.0;          ///< as in the file
  std::string midi;              ///< the controller that moves it, "cc 7"; or ""
  std::string osc;               ///< the foreign OSC address that moves it, "/1/fader3"; or ""
  std::optional<RigHid> hid;     ///< the axis or button that moves it
  std::string about;             ///< for people, as in the file
  /// [any] The last value that it was set to, SI.
  mutable std::atomic<double> value{0.0};

  /// [any] Its value as a position from 0 to 1 in its range, along its taper; 0 without a finite range.
  double position() const;
  /// [any] SI; the initial value without a finite range.
  double at_position(double position) const;
};

/// The rigid bodies of one world. Where it belongs to the simulated plant its name begins with "plant/".
struct RemoteWorld {
  std::string name;
  BodyLooks looks;
};

/// Bodies after the last step, in the order of RemoteDescription::worlds.
struct RemoteBodies {
  std::vector<BodyPoses> worlds;
};

/// What a client wants to know of bodies.
struct RemoteWatch {
  bool poses = false, impacts = false;

  bool operator==(const RemoteWatch&) const = default;
};

/// What can be read and set. The values of its controls follow the instrument; everything else of it stays,
/// and an edit of the instrument makes another description.
struct RemoteDescription {
  std::string instrument;
  std::vector<RemoteControl> controls;
  std::vector<std::string> gestures;
  std::vector<std::string> inputs, outputs;
  std::vector<std::string> guard_stages;  ///< in the order of RemoteMeters::guard
  std::vector<std::string> events = {};   ///< of the instrument: "hit"
  std::vector<std::string> presets = {};
  std::optional<double> world_delay_s = {};     ///< the delay of a simulated world: see order_verdict
  std::shared_ptr<const Picture> picture = {};  ///< nullptr: no server asked for it
  std::vector<RemoteWorld> worlds = {};

  /// [any] The place of a control or gesture, or -1.
  int find_control(std::string_view name) const;
  int find_gesture(std::string_view name) const;
};

/// One order to the control thread. Those of a bundle take effect in the same frame.
struct RemoteOrder {
  enum class Kind : std::uint8_t {
    Set,      ///< `number`: control; `value`: SI; `ramp_s`: until it is reached
    Trigger,  ///< `number`: control, which is 1 for a frame
    Gesture,  ///< `number`: gesture; `value`: of its signal
    Strike,   ///< `number`: gesture, which is 1 for a moment
    Arm,      ///< obeys RemoteTarget::order_arm
  };
  /// For a `time_s` that is no time: at once.
  static constexpr double kNow = -1.0;

  Kind kind = Kind::Set;
  bool last = true;  ///< of its bundle
  int number = -1;
  double value = 0.0;
  double ramp_s = 0.0;
  double time_s = kNow;                            ///< by the system clock, since 1970
  std::chrono::steady_clock::time_point received;  ///< when the packet came
};

/// What happened, for clients that subscribe to it.
struct RemoteEvent {
  enum class Kind : std::uint8_t {
    Message,  ///< `text`: as it is printed
    Guard,    ///< `text`: why the guard faded an output
    Armed,    ///< `value`: 1 or 0
    Muted,
    Trigger,   ///< `text`: name of the instrument's event; `level`: how strong it was
    Impact,    ///< `value`: world; `bodies`: of it; `level`: speed of approach [m/s]
    NotArmed,  ///< `text`: why an order to arm was not obeyed; for the client that gave it
  };
  Kind kind = Kind::Message;
  int value = 0;
  std::array<int, 2> bodies{};
  double level = 0.0;      ///< SI of its signal
  std::int64_t frame = 0;  ///< of the stream; of a message the frame that is being processed
  double time_s = 0.0;     ///< of that frame, by the system clock
  char text[200] = {};
};

struct RemoteMeters {
  std::vector<double> inputs, outputs;  ///< the highest sample since the last call, full scale = 1
  std::vector<double> guard;            ///< frames so far, of each stage of each output
  double load = 0.0;                    ///< 99.9th percentile of the share of a block's time
};

/// What changes all the time and is no level.
struct RemoteState {
  std::int64_t frame = 0;
  double time_s = 0.0;  ///< of that frame, by the system clock
  bool drives = false;  ///< there is something to arm
  std::string stream;   ///< "running", "lost", "stopped"
  double load = 0.0, worst_load = 0.0;
  std::int64_t xruns = 0, lost_frames = 0;
  std::vector<std::pair<std::string, std::int64_t>> faults;  ///< by node, so far
  std::vector<std::optional<double>> coil, body, excursion;  ///< of each output, as shares of the limits
  std::vector<double> signals;  ///< highest sample of each of the picture's signals, where they are asked for
};

/// What an edit of the files gave: errors, or none where it was taken over.
struct RemoteEdit {
  std::vector<Error> errors;
};

/// Whether the world would be stable with another system delay.
struct RemoteVerdict {
  double delay_s = 0.0;
  bool stable = false;  ///< it is certain
  std::string text;
};

/// What the scope shows now. Signals that cannot be shown are refused with a reason.
struct RemoteScope {
  std::uint32_t id = 0;
  std::vector<std::string> signals;
  std::vector<std::pair<std::string, std::string>> refused;
};

/// What needs a file or a device, and takes a moment.
struct RemoteRequest {
  enum class Kind : std::uint8_t {
    RecallPreset,
    SavePreset,
    Learn,  ///< the next MIDI controller or foreign OSC address is bound to a control; without a name: no
            ///< more
    LearntAddress,  ///< `name`: the OSC address
    LearntHid,      ///< `hid`: the axis or button
  };
  Kind kind = Kind::RecallPreset;
  std::string name;
  double ramp_s = 0.0;
  RigHid hid = {};
};

/// A running instrument. Functions of the network thread are called by one thread; several servers share it
/// (SharedRemote). They wait for no thread of the instrument.
class RemoteTarget {
 public:
  virtual ~RemoteTarget() = default;

  /// [any]
  virtual std::shared_ptr<const RemoteDescription> description() const = 0;
  /// [any, the network thread] The orders of a bundle, all or none. False: too many wait for the control
  /// thread.
  [[nodiscard]] virtual bool post(std::span<const RemoteOrder> bundle) = 0;

  /// [any] At once, whatever the control thread does.
  virtual void disarm() noexcept = 0;
  virtual void mute(bool on) noexcept = 0;
  virtual bool armed() const noexcept = 0;
  virtual bool muted() const noexcept = 0;
  /// [any] How often the drives were disarmed so far, by whomever.
  virtual int disarms() const noexcept = 0;
  /// [any, the network thread] The control thread is to arm the drives, which fade and disarm when
  /// `keep_alive` is not called for 0.5 s with the number that this returns. An order of kind Arm must
  /// follow. Errors: BadArgument: they are armed already.
  virtual Result<int> order_arm() = 0;
  /// [any, the network thread] Does nothing for the number of another arming.
  virtual void keep_alive(int arming) noexcept = 0;

  /// [any, the network thread]
  virtual RemoteMeters take_meters() = 0;
  virtual bool take_event(RemoteEvent& event) = 0;

  /// [any, the network thread] A message for the user.
  virtual void report(std::string /*text*/) {}
  /// [any, the network thread] A message with this OSC address came, which has no meaning. False: it gets
  /// none, because no control is being learnt.
  [[nodiscard]] virtual bool learn_address(const std::string& /*address*/) { return false; }
  /// [any, the network thread] The same of an axis or a button.
  [[nodiscard]] virtual bool learn_hid(const RigHid& /*source*/) { return false; }
  /// [any, the network thread] False: too many wait.
  [[nodiscard]] virtual bool request(RemoteRequest /*request*/) { return false; }

  // For screens: a target without them has none.
  /// [any] nullptr: nothing yet.
  virtual std::shared_ptr<const RemoteState> state() const { return nullptr; }
  virtual std::shared_ptr<const RemoteEdit> edit() const { return nullptr; }
  virtual std::shared_ptr<const RemoteScope> scope() const { return nullptr; }
  virtual std::shared_ptr<const RemoteVerdict> verdict() const { return nullptr; }
  /// [any, the network thread] The stability with this system delay; of several orders the last one counts.
  virtual void order_verdict(double /*delay_s*/) {}
  /// [any, the network thread] The scope shows these signals from now on; none: it is off.
  virtual void order_scope(std::uint32_t /*id*/, int /*bin*/, std::vector<std::string> /*signals*/) {}
  /// [any, the network thread] The state includes the levels of all signals from now on, or no longer.
  virtual void order_levels(bool /*on*/) {}
  virtual bool take_scope(ScopeChunk& /*chunk*/) { return false; }

  /// [any, the network thread] Bodies and events of kind Impact come from now on, or no longer.
  virtual void watch_bodies(RemoteWatch /*watch*/) {}
  /// [any] nullptr: nobody watches, or there was no step since.
  virtual std::shared_ptr<const RemoteBodies> bodies() const { return nullptr; }

  /// [any] How many bundles came after the time of their time tag.
  virtual std::int64_t late() const noexcept = 0;
};

}  // namespace tactus
