#include "engine/rig/rig_midi.h"

#include <fmt/format.h>

#include "engine/graph/file/read_fields.h"
#include "engine/graph/file/read_graph.h"
#include "engine/rig/rig_text.h"

namespace tactus {
namespace {

bool read_flag(const EntrySpec& entry, const std::string& key, Mistakes& mistakes) {
  const auto* value = find(entry.fields, key);
  if (value == nullptr) return false;
  if (value->flag() == nullptr)
    mistakes.add(Errc::WrongType, value->at, "'" + key + "' must be true or false, not " + value->kind(),
                 "write " + key + " = true");
  return value->flag() != nullptr && *value->flag();
}

int read_number(const EntrySpec& entry, const std::string& key, int low, int high, Mistakes& mistakes) {
  return static_cast<int>(read_whole(entry.fields, key, low, high, mistakes).value_or(low));
}

RigMidi read_one(const EntrySpec& entry, Mistakes& mistakes) {
  static const std::vector<std::string> kKeys = {"device",     "channel", "control", "note",
                                                 "pitch_bend", "fine",    "gate"};
  mistakes.unknown_keys(entry.fields, kKeys);
  RigMidi midi;
  midi.control = entry.name;
  midi.at = entry.at;
  midi.device = mistakes.text(entry.fields, "device");
  if (find(entry.fields, "channel") != nullptr) midi.channel = read_number(entry, "channel", 1, 16, mistakes);
  midi.fine = read_flag(entry, "fine", mistakes);
  midi.gate = read_flag(entry, "gate", mistakes);
  const bool note = find(entry.fields, "note") != nullptr, bend = read_flag(entry, "pitch_bend", mistakes);
  const bool control = find(entry.fields, "control") != nullptr;
  if (control + note + bend != 1)
    mistakes.add(
        Errc::Missing, entry.at,
        "'" + entry.name + "' is moved by " + (control + note + bend == 0 ? "nothing" : "two things"),
        "give one of control = 7, note = 36 and pitch_bend = true");
  if (note) midi.kind = RigMidi::Kind::Note;
  if (bend) midi.kind = RigMidi::Kind::PitchBend;
  if (control) midi.number = read_number(entry, "control", 0, midi.fine ? 31 : 127, mistakes);
  if (note) midi.number = read_number(entry, "note", 0, 127, mistakes);
  if (midi.fine && !control)
    mistakes.add(Errc::BadArgument, find(entry.fields, "fine")->at, "only controllers come in fine pairs",
                 "remove 'fine'");
  if (midi.gate && !note)
    mistakes.add(Errc::BadArgument, find(entry.fields, "gate")->at, "only a note is a gate", "remove 'gate'");
  return midi;
}

}  // namespace

bool RigMidi::same_source(const RigMidi& other) const {
  return device == other.device && channel == other.channel && kind == other.kind && number == other.number;
}

std::vector<RigMidi> read_midi(const Value::Table& rig, Mistakes& mistakes) {
  std::vector<RigMidi> all;
  for (const auto& entry : read_entries(rig, "midi", "{ control = 7 }", mistakes))
    if (!entry.broken) all.push_back(read_one(entry, mistakes));
  return all;
}

std::string to_text(const RigMidi& midi) {
  std::string text = midi.control + " = { ";
  if (!midi.device.empty()) text += "device = " + in_quotes(midi.device) + ", ";
  if (midi.channel > 0) text += fmt::format("channel = {}, ", midi.channel);
  text += midi.kind == RigMidi::Kind::Controller ? fmt::format("control = {}", midi.number)
          : midi.kind == RigMidi::Kind::Note     ? fmt::format("note = {}", midi.number)
                                                 : "pitch_bend = true";
  if (midi.fine) text += ", fine = true";
  if (midi.gate) text += ", gate = true";
  return text + " }";
}

}  // namespace tactus
