#include "remote/midi/midi_out_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/graph/file/error_list.h"

namespace tactus {
namespace {

using Kind = RigMidiOut::Kind;

constexpr int kFirstNote = 36, kDrumChannel = 10, kMostNotes = 128;
constexpr double kPulsesPerBeat = 24.0;
constexpr double kFastestBeats_hz = 100.0;
// A program that did not run for longer than this continues with the next pulse, without those between.
constexpr std::chrono::milliseconds kLate{100};
constexpr std::uint8_t kNoteOff = 0x80, kNoteOn = 0x90, kController = 0xb0, kPulse = 0xf8, kStart = 0xfa,
                       kStop = 0xfc;

std::uint8_t status(std::uint8_t kind, int channel) {
  return static_cast<std::uint8_t>(kind | ((channel - 1) & 0x0f));
}
std::uint8_t data(int value) { return static_cast<std::uint8_t>(std::clamp(value, 0, 127)); }

}  // namespace

std::vector<RigMidiOut> default_midi_out(const std::vector<std::string>& events) {
  std::vector<RigMidiOut> bindings;
  for (const auto& event : events) {
    const auto note = kFirstNote + static_cast<int>(bindings.size());
    if (note < kMostNotes)
      bindings.push_back({.name = event, .at = {}, .channel = kDrumChannel, .number = note});
  }
  return bindings;
}

MidiOutMap::MidiOutMap(std::vector<RigMidiOut> bindings, Send send)
    : bindings_(std::move(bindings)), send_(std::move(send)), last_(bindings_.size(), -1) {}

std::vector<Error> MidiOutMap::check(const RemoteDescription& description) const {
  std::vector<std::string> controls;
  for (const auto& control : description.controls) controls.push_back(control.name);
  std::vector<Error> errors;
  for (const auto& binding : bindings_) {
    const bool note = binding.kind == Kind::Note;
    const auto& names = note ? description.events : controls;
    const auto where = binding.at.text();
    if (std::ranges::find(names, binding.name) == names.end()) {
      errors.push_back(
          {Errc::UnknownName, where,
           fmt::format("the instrument has no {} '{}'", note ? "event" : "control", binding.name),
           suggest(binding.name, names, names.empty() ? "it has none" : "it has " + listed(names))});
      continue;
    }
    if (binding.kind != Kind::Clock) continue;
    const auto& control =
        description.controls[static_cast<std::size_t>(description.find_control(binding.name))];
    if (!(control.unit.dimension == Dimension{.second = -1}))
      errors.push_back({Errc::UnitMismatch, where,
                        "a clock needs a control in Hz, and '" + binding.name + "' is not",
                        "name one in Hz, such as a roll rate"});
  }
  return errors;
}

int MidiOutMap::velocity(double level, const RigMidiOut& binding) {
  if (!(level > binding.softest)) return 1;
  const double share = std::log(level / binding.softest) / std::log(binding.loudest / binding.softest);
  return 1 + static_cast<int>(std::lround(126.0 * std::clamp(share, 0.0, 1.0)));
}

void MidiOutMap::event(const RemoteEvent& event, Clock::time_point now) {
  if (event.kind != RemoteEvent::Kind::Trigger) return;
  for (const auto& binding : bindings_) {
    if (binding.kind != Kind::Note || binding.name != event.text) continue;
    const Note note{binding.channel, binding.number};
    if (sounding_.contains(note)) note_off(note);
    const std::array bytes{status(kNoteOn, note.first), data(note.second),
                           data(velocity(event.level, binding))};
    send_(bytes);
    const auto length = std::chrono::duration<double>{binding.length.value};
    sounding_[note] = now + std::chrono::duration_cast<Clock::duration>(length);
  }
}

void MidiOutMap::tick(const RemoteDescription& description, Clock::time_point now) {
  std::erase_if(sounding_, [&](const auto& entry) {
    if (entry.second > now) return false;
    note_off(entry.first);
    return true;
  });
  for (std::size_t b = 0; b < bindings_.size(); ++b) {
    const auto& binding = bindings_[b];
    const int place = binding.kind == Kind::Note ? -1 : description.find_control(binding.name);
    if (place < 0) continue;
    const auto& control = description.controls[static_cast<std::size_t>(place)];
    if (binding.kind == Kind::Controller) send_controller(binding, control, last_[b]);
    if (binding.kind == Kind::Clock) send_clock(binding, control.value, now);
  }
}

void MidiOutMap::send_controller(const RigMidiOut& binding, const RemoteControl& control, int& last) {
  const int value = static_cast<int>(std::lround(127.0 * control.position()));
  if (std::exchange(last, value) == value) return;
  const std::array bytes{status(kController, binding.channel), data(binding.number), data(value)};
  send_(bytes);
}

/// A change of the tempo applies from the next pulse on.
void MidiOutMap::send_clock(const RigMidiOut& binding, double hertz, Clock::time_point now) {
  const double beats_hz = std::min(hertz / binding.per_beat, kFastestBeats_hz);
  if (!(beats_hz > 0)) {
    if (std::exchange(pulses_.runs, false)) send_(std::array{kStop});
    return;
  }
  if (!pulses_.runs || now - pulses_.next > kLate) pulses_.next = now;
  if (!std::exchange(pulses_.runs, true)) send_(std::array{kStart});
  const auto interval = std::chrono::duration<double>{1.0 / (kPulsesPerBeat * beats_hz)};
  for (; pulses_.next <= now; pulses_.next += std::chrono::duration_cast<Clock::duration>(interval))
    send_(std::array{kPulse});
}

std::optional<MidiOutMap::Clock::time_point> MidiOutMap::due() const {
  std::optional<Clock::time_point> first;
  const auto add = [&](Clock::time_point time) { first = first ? std::min(*first, time) : time; };
  for (const auto& [note, until] : sounding_) add(until);
  if (pulses_.runs) add(pulses_.next);
  return first;
}

void MidiOutMap::stop() {
  for (const auto& [note, until] : sounding_) note_off(note);
  sounding_.clear();
  if (std::exchange(pulses_.runs, false)) send_(std::array{kStop});
}

void MidiOutMap::note_off(const Note& note) {
  const std::array bytes{status(kNoteOff, note.first), data(note.second), std::uint8_t{0}};
  send_(bytes);
}

}  // namespace tactus
