#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tactus {

/// What a player moved.
struct MidiMessage {
  enum class Kind : std::uint8_t {
    Controller,
    NoteOn,  ///< velocity 1 to 127
    NoteOff,
    PitchBend,
    ProgramChange,
  };
  Kind kind = Kind::Controller;
  int channel = 1;                             ///< 1 to 16
  int number = 0;                              ///< of the controller, note or program; 0 for pitch bend
  int value = 0;                               ///< 0 to 127; pitch bend 0 to 16383, at rest 8192
  std::chrono::steady_clock::time_point time;  ///< when it came
};

/// A message and the id of the port that it came from.
struct MidiEvent {
  std::string port;
  MidiMessage message;
};

/// How often ports are looked for.
inline constexpr std::chrono::milliseconds kMidiInterval{500};

/// Inputs that may come and go. All functions are called from one control thread and never wait for a device
/// or a server.
class MidiInputs {
 public:
  virtual ~MidiInputs() = default;
  /// [control] Ids of the ports that are open now. They stay the same when others come and go, and when the
  /// same device is plugged in again.
  virtual std::vector<std::string> ports() = 0;
  /// [control] Messages since the last call, port by port, each in order.
  virtual std::vector<MidiEvent> poll() = 0;
  /// [control] Messages, once each: ports that appeared or disappeared, and why there are none.
  virtual std::vector<std::string> news() = 0;
};

/// [control] MIDI inputs by RtMidi 5 through `api`: "alsa", "core", "winmm"; empty: that of the system.
/// JACK's are those of Backend::midi_inputs. Every `interval` ports are looked for and opened. A port that
/// leaves and returns within one `interval` is not seen to have left, and stays silent: RtMidi does not
/// report a lost connection.
///
/// An id is "api:name" with the name as the system gives it, without the numbers that change from one
/// plugging in to the next; the second of the same name is "api:name #2".
std::shared_ptr<MidiInputs> make_rtmidi(const std::string& api,
                                        std::chrono::milliseconds interval = kMidiInterval);

/// [any] The message of these bytes, with `time` left open; nothing if it is of no use to us. Source:
/// MIDI 1.0 Detailed Specification, table 1.
inline std::optional<MidiMessage> parse_midi(std::span<const std::uint8_t> bytes) noexcept {
  using Kind = MidiMessage::Kind;
  MidiMessage message;
  if (bytes.size() < 2 || bytes[1] > 127) return std::nullopt;
  message.channel = 1 + (bytes[0] & 0x0f);
  message.number = bytes[1];
  if ((bytes[0] & 0xf0) == 0xc0) {
    message.kind = Kind::ProgramChange;
    return bytes.size() == 2 ? std::optional{message} : std::nullopt;
  }
  if (bytes.size() != 3 || bytes[2] > 127) return std::nullopt;
  message.value = bytes[2];
  const int type = bytes[0] & 0xf0;
  if (type == 0x80 || (type == 0x90 && message.value == 0)) {  // a note that begins with velocity 0 ends
    message.kind = Kind::NoteOff;
  } else if (type == 0x90) {
    message.kind = Kind::NoteOn;
  } else if (type == 0xe0) {
    message.kind = Kind::PitchBend;
    message.value = bytes[1] + 128 * bytes[2];
    message.number = 0;
  } else if (type != 0xb0) {
    return std::nullopt;
  }
  return message;
}

}  // namespace tactus
