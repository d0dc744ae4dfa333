#include "apps/play/midi_map.h"

#include <cstdlib>

namespace tactus::app {
namespace {

using Kind = MidiMessage::Kind;

constexpr int kFineControllers = 32;  // 0 to 31 have their low bits in 32 to 63: MIDI 1.0, table 3
constexpr int kPitchBend = 128;       // no controller

bool from(const RigMidi& binding, const MidiEvent& event) {
  return event.port.find(binding.device) != std::string::npos &&
         (binding.channel == 0 || binding.channel == event.message.channel);
}

}  // namespace

std::vector<ControlMove> MidiMap::handle(const MidiEvent& event) {
  std::vector<ControlMove> moves;
  if (learning()) return watch(event), moves;
  for (const auto& binding : bindings_)
    if (const auto position = from(binding, event) ? position_of(binding, event) : std::nullopt)
      moves.push_back({binding.control, *position});
  const auto& message = event.message;
  if (message.kind == Kind::Controller && message.number < kFineControllers)
    high_bits_[{event.port, message.channel, message.number}] = message.value;
  return moves;
}

std::optional<double> MidiMap::position_of(const RigMidi& binding, const MidiEvent& event) {
  const auto& message = event.message;
  const bool same_number = message.number == binding.number;
  if (binding.kind == RigMidi::Kind::PitchBend)
    return message.kind == Kind::PitchBend ? std::optional{message.value / 16383.0} : std::nullopt;
  if (binding.kind == RigMidi::Kind::Note) {
    if (same_number && message.kind == Kind::NoteOn) return binding.gate ? 1.0 : message.value / 127.0;
    if (same_number && message.kind == Kind::NoteOff && binding.gate) return 0.0;
    return std::nullopt;
  }
  if (message.kind != Kind::Controller) return std::nullopt;
  // The high bits alone set the low ones to 0.
  if (same_number) return binding.fine ? 128 * message.value / 16383.0 : message.value / 127.0;
  if (!binding.fine || message.number != binding.number + kFineControllers) return std::nullopt;
  const auto high = high_bits_.find({event.port, message.channel, binding.number});
  if (high == high_bits_.end()) return std::nullopt;
  return (128 * high->second + message.value) / 16383.0;
}

void MidiMap::learn(const std::string& control) {
  learning_ = control;
  seen_.clear();
}

void MidiMap::watch(const MidiEvent& event) {
  const auto& message = event.message;
  if (message.kind == Kind::NoteOff || message.kind == Kind::ProgramChange) return;
  if (message.kind == Kind::NoteOn) return bind(event, RigMidi::Kind::Note, false);
  const bool bend = message.kind == Kind::PitchBend;
  const auto high = seen_.find({event.port, message.channel, message.number - kFineControllers});
  if (!bend && message.number < 2 * kFineControllers && high != seen_.end()) {
    high->second.fine = true;
    return;
  }
  // The wheel rests in its middle, and sends nothing before it leaves it.
  const auto [seen, fresh] =
      seen_.try_emplace({event.port, message.channel, bend ? kPitchBend : message.number},
                        Seen{bend ? 8192 : message.value, false});
  if (std::abs(message.value - seen->second.first) >= kLearnSteps * (bend ? 128 : 1))
    bind(event, bend ? RigMidi::Kind::PitchBend : RigMidi::Kind::Controller, seen->second.fine);
}

void MidiMap::bind(const MidiEvent& event, RigMidi::Kind kind, bool fine) {
  const auto& message = event.message;
  const RigMidi binding{
      std::exchange(learning_, {}), {}, event.port, message.channel, kind, message.number, fine};
  std::erase_if(bindings_, [&](const RigMidi& old) { return old.control == binding.control; });
  bindings_.push_back(binding);
  learnt_ = binding;
}

}  // namespace tactus::app
