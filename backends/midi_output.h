#pragma once
// Thread: [control, one thread]

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "engine/core/error.h"

namespace tactus {

/// The client of a port of our own.
inline constexpr const char* kMidiOutClient = "tactus_out";
/// [any] A port of this program, or of another one like it, which is not used as an input: what is sent would
/// come back.
inline bool is_own_output(const std::string& port) { return port.starts_with(kMidiOutClient); }

/// Where MIDI messages are sent.
class MidiOutput {
 public:
  virtual ~MidiOutput() = default;
  /// "alsa:nanoKONTROL2 CTRL", or of a port of our own "alsa:tactus_out".
  virtual const std::string& name() const = 0;
  /// One message. While the device is away it is lost.
  virtual void send(std::span<const std::uint8_t> bytes) = 0;
  /// To be called about every 0.5 s: looks whether the device was unplugged or is back. A message for the
  /// user where that changed.
  virtual std::optional<std::string> look() = 0;
};

/// [control] Opens the output whose id or a part of it is `port`, or without one a port of our own, which
/// other programs connect to. By RtMidi 5 through `api`: "alsa", "jack", "core", "winmm"; empty: that of the
/// system. Errors, at --midi-out: UnknownName, with the ports that there are; Device: why there is none.
Result<std::unique_ptr<MidiOutput>> open_midi_output(const std::string& api, const std::string& port);

}  // namespace tactus
