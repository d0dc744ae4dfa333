#include "backends/midi.h"

#include <catch2/catch.hpp>
#include <vector>

using namespace tactus;
using Bytes = std::vector<std::uint8_t>;

TEST_CASE("midi: bytes are what the MIDI specification says", "[midi]") {
  const auto controller = parse_midi(Bytes{0xb2, 7, 100});
  REQUIRE(controller);
  CHECK(controller->kind == MidiMessage::Kind::Controller);
  CHECK(controller->channel == 3);
  CHECK(controller->number == 7);
  CHECK(controller->value == 100);
  CHECK(parse_midi(Bytes{0x9f, 36, 64})->kind == MidiMessage::Kind::NoteOn);
  CHECK(parse_midi(Bytes{0x9f, 36, 64})->channel == 16);
  CHECK(parse_midi(Bytes{0x90, 36, 0})->kind == MidiMessage::Kind::NoteOff);
  CHECK(parse_midi(Bytes{0x80, 36, 64})->kind == MidiMessage::Kind::NoteOff);
  CHECK(parse_midi(Bytes{0xe0, 0, 64})->value == 8192);
  CHECK(parse_midi(Bytes{0xc2, 7})->kind == MidiMessage::Kind::ProgramChange);
  CHECK(parse_midi(Bytes{0xc2, 7})->channel == 3);
  CHECK(parse_midi(Bytes{0xc2, 7})->number == 7);
  CHECK_FALSE(parse_midi(Bytes{0xc2, 7, 0}));
  CHECK_FALSE(parse_midi(Bytes{0xc2, 128}));
  CHECK(parse_midi(Bytes{0xe0, 127, 127})->value == 16383);
}

TEST_CASE("midi: what is no message of ours, or broken, is nothing", "[midi]") {
  for (const auto& bytes : {Bytes{}, Bytes{0xf8}, Bytes{0xb0, 7}, Bytes{0xb0, 7, 200}, Bytes{7, 7, 7},
                            Bytes{0xd0, 1}, Bytes{0xc0}, Bytes{0xf0, 1, 2, 0xf7}})
    CHECK_FALSE(parse_midi(bytes));
}
