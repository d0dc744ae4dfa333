#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/play/live/controls/knobs.h"
#include "apps/play/midi_map.h"
#include "backends/midi.h"

namespace tactus::app {

/// MIDI controllers that turn the knobs of a session. Inputs are opened when something is bound or to be
/// learnt.
class MidiControls {
 public:
  /// `api`: a way to MIDI; empty: the system's.
  MidiControls(std::string api, std::vector<RigMidi> bindings, Knobs& knobs);

  /// [control] The next thing moved will move this control. False: this program has no MIDI.
  bool learn(const std::string& control);
  /// [control] Moves knobs; what happened in words.
  std::vector<std::string> tick();
  const std::vector<RigMidi>& bindings() const { return map_.bindings(); }

 private:
  bool open();

  std::string api_;
  Knobs& knobs_;
  MidiMap map_;
  std::unique_ptr<MidiInputs> inputs_;
};

}  // namespace tactus::app
