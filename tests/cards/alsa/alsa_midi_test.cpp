// MIDI of a real kernel: its sequencer, and ports that can be unplugged.
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <regex>

#include "backends/midi.h"
#include "tests/cards/alsa/cable_card.h"
#include "tests/cards/jack/playing.h"

using namespace tactus;
using test::CableCard;
using test::kSlowMachine;
using test::Playing;
using test::VirtualKeyboard;
using test::wait_until;

namespace {

bool says(Playing& play, const std::string& words) {
  return wait_until([&] { return play.log().find(words) != std::string::npos; }, kSlowMachine);
}

/// A control that is heard, at 0.1.
const std::string kLevel = R"(format = 1
name = "level"
[controls]
level = { value = 0.1, range = [0, 1] }
[nodes]
wave = { type = "sine", frequency = "100 Hz" }
[outputs]
tone = { from = "level * wave", kind = "audio" }
)";

/// Of the control, in the rig that is saved now; 0: it is not there.
double saved_level(Playing& play, const std::string& rig) {
  play.press("s");
  const std::regex line{"level *= *([0-9.]+)"};
  std::smatch found;
  const std::string text{std::istreambuf_iterator<char>{std::ifstream{rig}.rdbuf()}, {}};
  return std::regex_search(text, found, line) ? std::stod(found[1]) : 0.0;
}

}  // namespace

TEST_CASE("alsa: a keyboard on the sequencer is heard, also when it was pulled out and plugged in",
          "[.alsa]") {
  const VirtualKeyboard keyboard;
  const auto inputs = make_rtmidi("alsa", std::chrono::milliseconds{100});
  for (int turn = 0; turn < 3; ++turn) {
    REQUIRE(wait_until([&] { return !inputs->ports().empty(); }, kSlowMachine));
    const auto port = inputs->ports().front();
    CHECK(port.find("VirMIDI") != std::string::npos);
    std::vector<MidiEvent> heard;
    REQUIRE(wait_until(
        [&] {
          keyboard.play({0xb2, 7, static_cast<std::uint8_t>(20 + turn)});
          heard = inputs->poll();
          return !heard.empty();
        },
        kSlowMachine));
    CHECK(heard.front().port == port);
    CHECK(heard.front().message.channel == 3);
    CHECK(heard.front().message.value == 20 + turn);
    keyboard.pull();
    REQUIRE(wait_until([&] { return inputs->ports().empty(); }, kSlowMachine));
    keyboard.plug();
  }
}

TEST_CASE("alsa: a control learns its controller, and obeys it when that was away", "[.alsa]") {
  const CableCard card;
  const VirtualKeyboard keyboard;
  const test::TemporaryFolder folder;
  const auto level = folder.write("level.toml", kLevel).string();
  auto backend = test::backend_named("rtaudio");
  const auto device = card.output_of(*backend);
  REQUIRE(device);
  const auto rig = (folder.path() / "rig.toml").string();
  Playing play{{level, "--device", device->id, "--block", "2048", "--save-rig", rig, "--yes"}};
  REQUIRE(says(play, "delay "));
  play.press("l");
  REQUIRE(says(play, "move the MIDI controller for level"));
  REQUIRE(says(play, "MIDI from 'alsa:"));
  for (const int value : {10, 12, 14, 16, 18}) keyboard.play({0xb0, 7, static_cast<std::uint8_t>(value)});
  REQUIRE(says(play, "now controls level"));
  keyboard.pull();
  REQUIRE(says(play, "is disconnected; it is reopened when it reconnects"));
  const auto before = play.log().size();
  keyboard.plug();
  REQUIRE(wait_until([&] { return play.log().find("MIDI from 'alsa:", before) != std::string::npos; },
                     kSlowMachine));
  keyboard.play({0xb0, 7, 102});
  CHECK(wait_until([&] { return saved_level(play, rig) == Approx(102.0 / 127).margin(1e-3); }, kSlowMachine));
  play.press("q");
  CHECK(play.ends() == 0);
}
