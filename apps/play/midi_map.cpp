#include "apps/play/midi_map.h"

#include <algorithm>
#include <cstdlib>

namespace tactus::app {
namespace {

constexpr int kFineControllers = 32;  // 0 to 31 have their low bits in 32 to 63: MIDI 1.0, table 3
constexpr int kPitchBend = -1;

bool is_low_half(const MidiMessage& message) {
  return message.kind == MidiMessage::Kind::Controller && message.number >= kFineControllers &&
         message.number < 2 * kFineControllers;
}

bool from(const RigMidi& binding, const MidiEvent& event) {
  return event.port.find(binding.device) != std::string::npos &&
         (binding.channel == 0 || binding.channel == event.message.channel);
}

}  // namespace

std::vector<ControlMove> MidiMap::hear(const MidiEvent& event) {
  std::vector<ControlMove> moves;
  if (learning()) return watch(event), moves;
  for (const auto& binding : bindings_) {
    if (!from(binding, event)) continue;
    if (const auto place = place_of(binding, event)) moves.push_back({binding.control, *place});
  }
  const auto& message = event.message;
  if (message.kind == MidiMessage::Kind::Controller && message.number < kFineControllers)
    high_bits_[{event.port, {message.channel, message.number}}] = message.value;
  return moves;
}

std::optional<double> MidiMap::place_of(const RigMidi& binding, const MidiEvent& event) {
  const auto& message = event.message;
  switch (binding.kind) {
    case RigMidi::Kind::PitchBend:
      if (message.kind != MidiMessage::Kind::PitchBend) return std::nullopt;
      return message.value / 16383.0;
    case RigMidi::Kind::Note:
      if (message.number != binding.number) return std::nullopt;
      if (message.kind == MidiMessage::Kind::NoteOn) return binding.gate ? 1.0 : message.value / 127.0;
      if (message.kind == MidiMessage::Kind::NoteOff && binding.gate) return 0.0;
      return std::nullopt;
    case RigMidi::Kind::Controller:
      break;
  }
  if (message.kind != MidiMessage::Kind::Controller) return std::nullopt;
  if (!binding.fine)
    return message.number == binding.number ? std::optional{message.value / 127.0} : std::nullopt;
  // The high bits alone set the low ones to 0.
  if (message.number == binding.number) return 128 * message.value / 16383.0;
  if (message.number != binding.number + kFineControllers) return std::nullopt;
  const auto high = high_bits_.find({event.port, {message.channel, binding.number}});
  if (high == high_bits_.end()) return std::nullopt;
  return (128 * high->second + message.value) / 16383.0;
}

void MidiMap::learn(const std::string& control) {
  learning_ = control;
  heard_.clear();
}

void MidiMap::watch(const MidiEvent& event) {
  const auto& message = event.message;
  if (message.kind == MidiMessage::Kind::NoteOff) return;
  if (message.kind == MidiMessage::Kind::NoteOn)
    return bind(event, RigMidi::Kind::Note, message.number, false);
  if (is_low_half(message)) {
    const auto high = heard_.find({event.port, {message.channel, message.number - kFineControllers}});
    if (high != heard_.end()) {
      high->second.fine = true;
      return;
    }
  }
  const bool bend = message.kind == MidiMessage::Kind::PitchBend;
  const Knob knob{event.port, {message.channel, bend ? kPitchBend : message.number}};
  // The wheel rests in its middle, and is not heard of before it leaves it.
  const auto [heard, fresh] = heard_.try_emplace(knob, Heard{bend ? 8192 : message.value, false});
  if (std::abs(message.value - heard->second.first) < kLearnSteps * (bend ? 128 : 1)) return;
  bind(event, bend ? RigMidi::Kind::PitchBend : RigMidi::Kind::Controller, message.number,
       heard->second.fine);
}

void MidiMap::bind(const MidiEvent& event, RigMidi::Kind kind, int number, bool fine) {
  RigMidi binding;
  binding.control = std::exchange(learning_, {});
  binding.device = event.port;
  binding.channel = event.message.channel;
  binding.kind = kind;
  binding.number = number;
  binding.fine = fine;
  std::erase_if(bindings_, [&](const RigMidi& old) { return old.control == binding.control; });
  bindings_.push_back(binding);
  learnt_ = binding;
}

}  // namespace tactus::app
