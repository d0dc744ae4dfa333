#include "engine/rig/rig_midi.h"

#include <fmt/format.h>

#include "engine/graph/file/field.h"
#include "engine/graph/file/read_graph.h"
#include "engine/rig/rig_text.h"

namespace tactus {
namespace {

RigMidi read_one(const EntrySpec& entry, ErrorList& mistakes) {
  FieldReader fields{entry.fields, midi_fields(), mistakes};
  const auto number = [&](const char* key, double most = kUnlimited) {
    return static_cast<int>(fields.number(key, most).value_or(midi_fields()[key].low));
  };
  RigMidi midi;
  midi.control = entry.name;
  midi.at = entry.at;
  midi.device = fields.text("device");
  if (fields.has("channel")) midi.channel = number("channel");
  midi.fine = fields.flag("fine");
  midi.gate = fields.flag("gate");
  const bool note = fields.has("note"), bend = fields.flag("pitch_bend"), control = fields.has("control");
  if (control + note + bend != 1)
    mistakes.add(
        Errc::Missing, entry.at,
        "'" + entry.name + "' is moved by " + (control + note + bend == 0 ? "nothing" : "two things"),
        "give one of control = 7, note = 36 and pitch_bend = true");
  if (note) midi.kind = RigMidi::Kind::Note;
  if (bend) midi.kind = RigMidi::Kind::PitchBend;
  if (control) midi.number = number("control", midi.fine ? 31 : 127);
  if (note) midi.number = number("note");
  if (midi.fine && !control)
    mistakes.add(Errc::BadArgument, fields.value("fine")->at, "only controllers come in fine pairs",
                 "remove 'fine'");
  if (midi.gate && !note)
    mistakes.add(Errc::BadArgument, fields.value("gate")->at, "only a note is a gate", "remove 'gate'");
  return midi;
}

}  // namespace

const SectionType& midi_fields() {
  using Kind = FieldType::Kind;
  static const SectionType section{"what moves a control",
                                   {text_field("device", "a part of the port's name", "any"),
                                    whole_field("channel", 1, 16, "channel", "any"),
                                    whole_field("control", 0, 127, "number of the controller"),
                                    whole_field("note", 0, 127, "its velocity moves the control"),
                                    field("pitch_bend", Kind::Flag, "the pitch wheel moves the control"),
                                    field("fine", Kind::Flag, "14 bits, with controller + 32"),
                                    field("gate", Kind::Flag, "a note opens and closes")}};
  return section;
}

bool RigMidi::same_source(const RigMidi& other) const {
  return device == other.device && channel == other.channel && kind == other.kind && number == other.number;
}

std::vector<RigMidi> read_midi(const Value::Table& rig, ErrorList& mistakes) {
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
