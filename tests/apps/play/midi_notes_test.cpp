#include "apps/play/live/controls/midi_notes.h"

#include <catch2/catch.hpp>

#include "tests/support/graphs/graph_runner.h"

using namespace tactus;
using app::MidiNotes;

namespace {

MidiMessage note(MidiMessage::Kind kind, int number, int velocity) {
  return {.kind = kind, .number = number, .value = velocity, .time = {}};
}
constexpr auto kOn = MidiMessage::Kind::NoteOn, kOff = MidiMessage::Kind::NoteOff;

const std::string kKeyboard =
    "format = 1\n[controls]\n"
    "key = { value = 0, range = [0, 127], midi = \"note\" }\n"
    "strength = { value = 0, range = [0, 1], midi = \"velocity\" }\n"
    "down = { value = 0, range = [0, 1], midi = \"note_on\" }\n"
    "up = { value = 0, range = [0, 1], midi = \"note_off\" }\n[nodes]\n"
    "voice = { type = \"poly\", pitch = \"key\", note_on = \"down\", note_off = \"up\", level = "
    "\"strength\", voices = "
    "3 }\n"
    "[outputs]\nout = { from = \"voice.gate * (voice.pitch + voice.level)\" }\n";

}  // namespace

TEST_CASE("MIDI notes: a chord that comes at once plays on as many voices, the same for every block size",
          "[play]") {
  for (const int block : {1, 16, 64}) {
    auto engine = test::engine_of(kKeyboard);
    std::vector<MidiNotes::Follower> followers;
    for (const auto& planned : engine->plan().controls)
      followers.push_back(
          {planned.control.midi, engine->control_index(planned.control.name), planned.control.range});
    MidiNotes notes;
    notes.follow(followers);
    for (const int number : {60, 64, 67}) notes.play(note(kOn, number, 127), 10);
    notes.play(note(kOff, 64, 0), 30);
    std::vector<JournalEntry> entries;
    notes.flush([&](const JournalEntry& entry) { return entries.push_back(entry), true; });
    engine->set_journal(entries);
    const auto out = test::run(*engine, {}, 40, {block});
    // Each note two frames after the one before.
    CHECK(out[0][9] == 0);
    CHECK(out[0][10] == 61);
    CHECK(out[1][11] == 0);
    CHECK(out[1][12] == 65);
    CHECK(out[2][14] == 68);
    CHECK(out[1][29] == 65);
    CHECK(out[1][30] == 0);
    CHECK(out[0][39] == 61);
  }
}

TEST_CASE("MIDI notes: what the queue has no room for is posted later, in order", "[play]") {
  MidiNotes notes;
  notes.follow({{MidiRole::Note, 4, {0, 127}}, {MidiRole::NoteOn, 5, {0, 1}}});
  notes.play(note(kOn, 60, 1), 100);
  std::vector<JournalEntry> entries;
  const auto post = [&](const JournalEntry& entry) { return entries.push_back(entry), true; };
  int room = 2;
  notes.flush([&](const JournalEntry& entry) { return room-- > 0 && post(entry); });
  CHECK(entries.size() == 2);
  notes.flush(post);
  using Kind = JournalEntry::Kind;
  CHECK(entries == std::vector<JournalEntry>{{100, Kind::ControlSet, 4, 60},
                                             {100, Kind::ControlSet, 5, 1},
                                             {101, Kind::ControlSet, 5, 0}});
  notes.play(note(MidiMessage::Kind::Controller, 1, 1), 200);
  notes.flush(post);
  CHECK(entries.size() == 3);
}
