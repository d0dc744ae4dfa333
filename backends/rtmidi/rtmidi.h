#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "backends/midi.h"

namespace tactus {

struct RtMidiSettings {
  std::string api;   ///< "alsa", "jack", "core", "winmm"; empty: that of the system
  std::string only;  ///< a part of the ids to open, in any case; empty: all
  std::string client_name = "tactus_midi";
  std::chrono::milliseconds look_every{500};  ///< for what came and went
};

/// [control] MIDI inputs by RtMidi 5. Ports are looked for and opened on a thread of its own, because servers
/// may hang: a call that never returns costs that thread and nothing else.
///
/// An id is "api:name" with the name as the system gives it, without the numbers that change from one
/// plugging in to the next; the second of the same name is "api:name #2".
std::unique_ptr<MidiInputs> make_rtmidi(const RtMidiSettings& settings = {});

}  // namespace tactus
