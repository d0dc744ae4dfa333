#pragma once
// Thread: [control]

#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "backends/midi.h"
#include "engine/rig/rig.h"

namespace tactus::app {

/// A control and its new position: 0 to 1 of its range, along its taper.
struct ControlMove {
  std::string control;
  double position = 0;
};

/// Turns MIDI messages into controls, and learns which message moves which.
class MidiMap {
 public:
  explicit MidiMap(std::vector<RigMidi> bindings) : bindings_(std::move(bindings)) {}

  /// The controls that this moves. During MIDI learn nothing moves.
  std::vector<ControlMove> handle(const MidiEvent& event);

  /// The next controller, note or pitch wheel that is moved will move `control`. A controller must come at
  /// least `kLearnSteps` of its 127 steps away from where it was first: worn ones jitter by one or two.
  void learn(const std::string& control);
  bool learning() const { return !learning_.empty(); }
  /// What is being learnt, or "".
  const std::string& control() const { return learning_; }
  /// The binding that was learnt, once. It is among `bindings` already, instead of the former one of the
  /// control.
  std::optional<RigMidi> take_learnt() { return std::exchange(learnt_, std::nullopt); }

  const std::vector<RigMidi>& bindings() const { return bindings_; }
  static constexpr int kLearnSteps = 4;

 private:
  using Source = std::tuple<std::string, int, int>;  ///< port, channel, number
  struct Seen {
    int first = 0;
    bool fine = false;  ///< its low seven bits came too
  };

  void watch(const MidiEvent& event);
  void bind(const MidiEvent& event, RigMidi::Kind kind, bool fine);
  std::optional<double> position_of(const RigMidi& binding, const MidiEvent& event);

  std::vector<RigMidi> bindings_;
  std::string learning_;
  std::map<Source, Seen> seen_;      ///< since MIDI learn began
  std::map<Source, int> high_bits_;  ///< last values of controllers 0 to 31
  std::optional<RigMidi> learnt_;
};

}  // namespace tactus::app
