#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "backends/midi.h"
#include "engine/rig/rig.h"

namespace tactus::app {

/// A control and where its knob goes: 0 to 1 of its way, whose range and taper are the knob's own.
struct ControlMove {
  std::string control;
  double place = 0;
};

/// Turns what a player moves into controls, and learns what moves which. [control]
class MidiMap {
 public:
  explicit MidiMap(std::vector<RigMidi> bindings) : bindings_(std::move(bindings)) {}

  /// What this moves, and how far. While it learns, nothing moves.
  std::vector<ControlMove> hear(const MidiEvent& event);

  /// The next controller, note or pitch wheel that is moved will move `control`. A controller must come at
  /// least `kLearnSteps` of its 127 steps away from where it was first heard: worn knobs jitter by one or
  /// two.
  void learn(const std::string& control);
  void stop_learning() { learning_.clear(); }
  bool learning() const { return !learning_.empty(); }
  /// What it learnt, once. It is among `bindings` already, in the place of what moved the control before.
  std::optional<RigMidi> take_learnt() { return std::exchange(learnt_, std::nullopt); }

  const std::vector<RigMidi>& bindings() const { return bindings_; }
  static constexpr int kLearnSteps = 4;

 private:
  /// Something that a player can move: port, channel, number.
  using Knob = std::pair<std::string, std::pair<int, int>>;
  struct Heard {
    int first = 0;
    bool fine = false;  ///< its low seven bits came too
  };

  void watch(const MidiEvent& event);
  void bind(const MidiEvent& event, RigMidi::Kind kind, int number, bool fine);
  std::optional<double> place_of(const RigMidi& binding, const MidiEvent& event);

  std::vector<RigMidi> bindings_;
  std::string learning_;
  std::map<Knob, Heard> heard_;    ///< since it learns
  std::map<Knob, int> high_bits_;  ///< last values of controllers 0 to 31
  std::optional<RigMidi> learnt_;
};

}  // namespace tactus::app
