#pragma once
// Thread: [control]

#include <memory>
#include <string>
#include <vector>

#include "apps/play/live/controls/live_controls.h"
#include "apps/play/midi_map.h"
#include "backends/midi.h"

namespace tactus::app {

/// MIDI controllers that move the controls of a session. Inputs are opened when something is bound or MIDI
/// learn is on.
class MidiControls {
 public:
  /// `api`: a way to MIDI; empty: the system's.
  MidiControls(std::string api, std::vector<RigMidi> bindings, LiveControls& controls);

  /// [control] The next thing moved will move this control. False: this program has no MIDI.
  bool learn(const std::string& control);
  /// [control] Moves controls; messages for the user.
  std::vector<std::string> tick();
  const std::vector<RigMidi>& bindings() const { return map_.bindings(); }

 private:
  bool open();

  std::string api_;
  LiveControls& controls_;
  MidiMap map_;
  std::unique_ptr<MidiInputs> inputs_;
};

}  // namespace tactus::app
