#include "backends/midi.h"

namespace tactus {

// Numbers of the messages: MIDI 1.0 Detailed Specification, table 1.
std::optional<MidiMessage> parse_midi(std::span<const std::uint8_t> bytes) noexcept {
  using Kind = MidiMessage::Kind;
  if (bytes.size() != 3 || bytes[1] > 127 || bytes[2] > 127) return std::nullopt;
  MidiMessage message;
  message.channel = 1 + (bytes[0] & 0x0f);
  message.number = bytes[1];
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
