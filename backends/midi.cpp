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
  switch (bytes[0] & 0xf0) {
    case 0x80:
      message.kind = Kind::NoteOff;
      return message;
    case 0x90:  // a note that begins with velocity 0 ends
      message.kind = message.value > 0 ? Kind::NoteOn : Kind::NoteOff;
      return message;
    case 0xb0:
      message.kind = Kind::Controller;
      return message;
    case 0xe0:
      message.kind = Kind::PitchBend;
      message.value = bytes[1] + 128 * bytes[2];
      message.number = 0;
      return message;
    default:
      return std::nullopt;
  }
}

}  // namespace tactus
