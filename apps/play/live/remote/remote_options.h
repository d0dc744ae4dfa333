#pragma once
// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "engine/rig/rig.h"

namespace tactus::app {

/// What reaches a session from outside, and what it sends.
struct RemoteOptions {
  std::string osc;                      ///< [ADDRESS:]PORT; empty: no server
  bool osc_arm = false;                 ///< clients of other hosts may arm
  std::vector<std::string> serial;      ///< DEVICE[@BAUD]
  std::optional<std::string> hid;       ///< a part of a device's name; empty: all
  std::optional<std::string> midi_out;  ///< a part of a port's name; empty: a port of our own
  std::string midi;                     ///< MIDI backend; empty: that of the system
  std::optional<std::string> panel;     ///< [ADDRESS:]PORT, or empty: any port; nothing: no server
  bool panel_arm = false;
  bool no_browser = false;
  // Of the rig.
  bool midi_by_rig = false;               ///< only the rig asks for MIDI messages
  std::vector<RigMidiOut> midi_messages;  ///< none: a note for each event

  bool any() const { return !osc.empty() || !serial.empty() || hid || midi_out || panel; }
};

}  // namespace tactus::app
