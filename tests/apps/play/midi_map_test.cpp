#include "apps/play/midi_map.h"

#include <catch2/catch.hpp>
#include <random>

using namespace tactus;
using namespace tactus::app;

namespace {

using Kind = MidiMessage::Kind;

MidiEvent event(Kind kind, int number, int value, int channel = 1, const std::string& port = "alsa:nano") {
  return {port, {kind, channel, number, value, {}}};
}

RigMidi binding(const std::string& control_name, RigMidi::Kind kind, int number) {
  RigMidi made;
  made.control = control_name;
  made.kind = kind;
  made.number = number;
  return made;
}

/// Where a message puts the one control that it moves.
double moved(MidiMap& map, const MidiEvent& last) {
  const auto moves = map.handle(last);
  REQUIRE(moves.size() == 1);
  return moves[0].position;
}

}  // namespace

TEST_CASE("midi_map: a controller moves its control from one end to the other", "[midi]") {
  MidiMap map{{binding("length", RigMidi::Kind::Controller, 7)}};
  CHECK(moved(map, event(Kind::Controller, 7, 0)) == 0.0);
  CHECK(moved(map, event(Kind::Controller, 7, 64)) == Approx(64 / 127.0));
  CHECK(moved(map, event(Kind::Controller, 7, 127)) == 1.0);
  CHECK(map.handle(event(Kind::Controller, 9, 64)).empty());
}

TEST_CASE("midi_map: only the device and the channel that a binding names", "[midi]") {
  auto only = binding("strength", RigMidi::Kind::Controller, 7);
  only.device = "nano";
  only.channel = 3;
  MidiMap map{{only}};
  CHECK(map.handle(event(Kind::Controller, 7, 10, 3)).size() == 1);
  CHECK(map.handle(event(Kind::Controller, 7, 10, 4)).empty());
  CHECK(map.handle(event(Kind::Controller, 7, 10, 3, "alsa:other")).empty());
}

TEST_CASE("midi_map: a fine pair has 14 bits, high bits first", "[midi]") {
  auto fine = binding("strength", RigMidi::Kind::Controller, 1);
  fine.fine = true;
  MidiMap map{{fine}};
  CHECK(map.handle(event(Kind::Controller, 33, 5)).empty());  // low bits of nothing
  CHECK(moved(map, event(Kind::Controller, 1, 64)) == Approx(64 * 128 / 16383.0));
  CHECK(moved(map, event(Kind::Controller, 33, 5)) == Approx((64 * 128 + 5) / 16383.0));
  CHECK(moved(map, event(Kind::Controller, 1, 127)) == Approx(127 * 128 / 16383.0));
  CHECK(moved(map, event(Kind::Controller, 33, 127)) == 1.0);
}

TEST_CASE("midi_map: notes give their velocity, or open and close a gate, and the wheel has 14 bits",
          "[midi]") {
  auto gate = binding("length", RigMidi::Kind::Note, 38);
  gate.gate = true;
  MidiMap map{{binding("strength", RigMidi::Kind::Note, 36), gate,
               binding("sensitivity", RigMidi::Kind::PitchBend, 0)}};
  CHECK(moved(map, event(Kind::NoteOn, 36, 100)) == Approx(100 / 127.0));
  CHECK(map.handle(event(Kind::NoteOff, 36, 0)).empty());
  CHECK(moved(map, event(Kind::NoteOn, 38, 1)) == 1.0);
  CHECK(moved(map, event(Kind::NoteOff, 38, 64)) == 0.0);
  CHECK(moved(map, event(Kind::PitchBend, 0, 16383)) == 1.0);
  CHECK(moved(map, event(Kind::PitchBend, 0, 0)) == 0.0);
}

TEST_CASE("midi_map: learns the knob that is moved, and not the one that jitters", "[midi]") {
  MidiMap map{{binding("strength", RigMidi::Kind::Controller, 99)}};
  map.learn("strength");
  for (int i = 0; i < 100; ++i) CHECK(map.handle(event(Kind::Controller, 10, 60 + i % 3)).empty());
  for (int value = 20; value < 24; ++value) map.handle(event(Kind::Controller, 7, value, 5));
  CHECK(map.learning());
  CHECK(map.handle(event(Kind::Controller, 7, 24, 5)).empty());
  CHECK_FALSE(map.learning());
  const auto learnt = map.take_learnt();
  REQUIRE(learnt);
  CHECK(learnt->control == "strength");
  CHECK(learnt->device == "alsa:nano");
  CHECK(learnt->channel == 5);
  CHECK(learnt->number == 7);
  CHECK_FALSE(learnt->fine);
  CHECK_FALSE(map.take_learnt());
  REQUIRE(map.bindings().size() == 1);  // in the place of controller 99
  CHECK(moved(map, event(Kind::Controller, 7, 127, 5)) == 1.0);
}

TEST_CASE("midi_map: learns fine pairs, notes and the wheel for what they are", "[midi]") {
  MidiMap map{std::vector<RigMidi>{}};
  map.learn("strength");
  for (int step = 0; map.learning(); ++step) {
    REQUIRE(step < 1000);
    map.handle(event(Kind::Controller, 2, step / 8));
    map.handle(event(Kind::Controller, 34, step % 8 * 16));
  }
  CHECK(map.take_learnt()->fine);
  CHECK(map.bindings()[0].number == 2);
  map.learn("length");
  map.handle(event(Kind::NoteOff, 36, 0));
  CHECK(map.learning());
  map.handle(event(Kind::NoteOn, 36, 1));
  CHECK(map.take_learnt()->kind == RigMidi::Kind::Note);
  map.learn("sensitivity");
  map.handle(event(Kind::PitchBend, 0, 8192 + 300));
  CHECK(map.learning());
  map.handle(event(Kind::PitchBend, 0, 8192 + 600));
  CHECK(map.take_learnt()->kind == RigMidi::Kind::PitchBend);
  CHECK_FALSE(map.take_learnt());
}

TEST_CASE("midi_map: a thousand hostile streams move controls within their range and bind what exists",
          "[midi]") {
  std::mt19937 random{1};
  const auto below = [&](unsigned limit) { return random() % limit; };
  for (int stream = 0; stream < 1000; ++stream) {
    auto fine = binding("fine", RigMidi::Kind::Controller, static_cast<int>(below(32)));
    fine.fine = true;
    MidiMap map{{fine, binding("coarse", RigMidi::Kind::Controller, static_cast<int>(below(128))),
                 binding("note", RigMidi::Kind::Note, static_cast<int>(below(128)))}};
    for (int n = 0; n < 200; ++n) {
      if (below(20) == 0) map.learn("learnt");
      std::vector<std::uint8_t> bytes(below(6));
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(below(256));
      if (!bytes.empty() && below(2) == 0) {  // as if it were a message
        bytes.resize(3);
        bytes[0] = static_cast<std::uint8_t>(0x80 | bytes[0]);
        bytes[1] &= 127, bytes[2] &= 127;
      }
      const auto message = parse_midi(bytes);
      if (!message) continue;
      for (const auto& move : map.handle({"alsa:" + std::to_string(below(3)), *message})) {
        CHECK(move.position >= 0.0);
        CHECK(move.position <= 1.0);
      }
      if (const auto learnt = map.take_learnt()) CHECK(learnt->control == "learnt");
    }
    CHECK(map.bindings().size() <= 4);
  }
}
