#include "engine/rig/rig.h"

#include <catch2/catch.hpp>

#include "engine/graph/file/load.h"
#include "engine/graph/plan/compile.h"
#include "engine/nodes/table.h"
#include "engine/rig/check_rig.h"
#include "engine/scene/guard_report.h"
#include "tests/support/error_summary.h"
#include "tests/support/parse_graph.h"

using namespace tactus;
using tactus::test::parse_graph;

namespace {

const std::string kRoot = std::string{TACTUS_SOURCE_DIR} + "/instruments";
const ProfilePlaces kProfiles{{}, {}, {kRoot}};

const std::string kDesk = R"(format = 1
name = "my desk"
[device]
output = "jack:system"
rate = "48 kHz"
block = 64
[inputs]
microphone = { channel = 1, volts_per_full_scale = "1 V", sensitivity = "50 mV" }
[outputs]
woofer = { channel = 2, profile = "woofer", volts_per_full_scale = "10 V", ceiling = 0.8 }
sound = { channel = 1 }
[actuators]
shaker = { channel = 3, profile = "bass_shaker", volts_per_full_scale = "10 V" }
[controls]
strength = 0.6
sensitivity = "-40 dB"
[midi]
strength = { device = "nanoKONTROL", channel = 1, control = 7 }
[delay]
measured = "12.4 ms"
)";

Rig rig_of(const std::string& text) {
  auto rig = parse_rig(text, "rig.toml", kProfiles);
  INFO((rig ? "" : to_string(rig.error())));
  REQUIRE(rig);
  return *rig;
}

/// With the least that a rig must say before them.
std::string errors_of(const std::string& lines) {
  const auto rig = parse_rig("format = 1\n[device]\noutput = \"x\"\n" + lines, "rig.toml", kProfiles);
  return test::summary(rig);
}

std::shared_ptr<const GraphSpec> drum() {
  static const auto graph = load_graph(kRoot + "/haptic_drum/instrument.toml", kRoot);
  REQUIRE(graph);
  return *graph;
}

std::string misfits(const std::string& lines) {
  const auto rig = rig_of("format = 1\n[device]\noutput = \"x\"\n" + lines);
  return test::summary(check_rig(rig, *drum()));
}

}  // namespace

TEST_CASE("rig: channels of the second device are its own", "[rig]") {
  const std::string text = R"(format = 1
[device]
output = "jack:system"
second = "sdl:Pad"
[inputs]
stick = { channel = 2, second = true }
[outputs]
slow = { channel = [1, 2], second = true }
sound = { channel = [1, 2] }
)";
  const auto rig = rig_of(text);
  CHECK(rig.device.second == "sdl:Pad");
  CHECK(rig.inputs[0].on_second_device());
  CHECK(rig.inputs[0].channels == std::vector{kSecondDevice + 2});
  CHECK(rig.outputs[0].channels == std::vector{kSecondDevice + 1, kSecondDevice + 2});
  CHECK_FALSE(rig.outputs[1].on_second_device());
  const auto again = rig_of(to_text(rig));
  CHECK(again.outputs[0].channels == rig.outputs[0].channels);
  CHECK(again.device.second == "sdl:Pad");
  CHECK(channel_name(3) == "channel 3");
  CHECK(channel_name(kSecondDevice + 3) == "channel 3 of the second device");
  CHECK(errors_of("[inputs]\nstick = { channel = 1, second = true }\n") ==
        "rig.toml:5:33 Missing [device] second \"sdl:Xbox Wireless Controller\"");
}

TEST_CASE("rig: every line of a rig means what it says", "[rig]") {
  const auto rig = rig_of(kDesk);
  CHECK(rig.name == "my desk");
  CHECK(rig.device.output == "jack:system");
  CHECK(rig.device.rate == 48_kHz);
  CHECK(rig.device.block == 64);
  CHECK_FALSE(rig.device.periods);
  REQUIRE(rig.inputs.size() == 1);
  CHECK(rig.inputs[0].channels == std::vector{1});
  CHECK(rig.inputs[0].scale() == Approx(20).epsilon(1e-12));  // 1 V / 50 mV
  REQUIRE(rig.outputs.size() == 2);
  CHECK(rig.outputs[0].drive.limits().ceiling == 0.8);
  CHECK(rig.outputs[0].drive.limits().heat->watts_at_full_scale == Approx(100 / 6.5));  // V^2 / R
  CHECK(rig.outputs[1].drive.limits().ceiling == conservative_limits().ceiling);
  REQUIRE(rig.actuator_on(3) != nullptr);
  CHECK(rig.actuator_on(3)->name == "shaker");
  CHECK(rig.actuator_on(2)->name == "woofer");
  CHECK(rig.actuator_on(1) == nullptr);
  CHECK(rig.controls[1].value.si == Approx(0.01));
  REQUIRE(rig.midi.size() == 1);
  CHECK(rig.midi[0].number == 7);
  CHECK(rig.measured_delay->value == Approx(12.4e-3));
}

TEST_CASE("rig: a written rig reads back the same, to the last bit", "[rig]") {
  auto rig = rig_of(kDesk);
  rig.about = "quotes \" and \\ and\nlines";
  rig.device.input = "alsa:\"two\"";
  rig.device.periods = 3;
  rig.pad_delay = Seconds{0.1 + 0.2};
  rig.controls[0].value.si = 1.0 / 3;
  rig.inputs[0].volts = 1.2345678901234567;
  rig.outputs[1].channels = {4, 5, 6};
  rig.outputs[1].highpass = Hertz{1.0 / 3};
  rig.midi.push_back({"a", {}, "", 0, RigMidi::Kind::Note, 36, false, true});
  rig.midi.push_back({"b", {}, "x", 16, RigMidi::Kind::PitchBend, 0, false, false});
  rig.midi.push_back({"c", {}, "", 0, RigMidi::Kind::Controller, 1, true, false});
  const auto text = to_text(rig);
  INFO(text);
  const auto again = rig_of(text);
  CHECK(to_text(again) == text);
  CHECK(again.about == rig.about);
  CHECK(again.device.input == rig.device.input);
  CHECK(again.pad_delay == rig.pad_delay);
  CHECK(again.measured_delay == rig.measured_delay);
  CHECK(again.controls[0].value.si == rig.controls[0].value.si);
  CHECK(again.controls[1].value.si == rig.controls[1].value.si);
  CHECK(again.inputs[0].scale() == rig.inputs[0].scale());
  CHECK(again.outputs[1].channels == rig.outputs[1].channels);
  CHECK(again.outputs[1].highpass == rig.outputs[1].highpass);
  CHECK_FALSE(again.outputs[0].highpass);
  CHECK(again.midi[1].gate);
  CHECK(again.midi[2].kind == RigMidi::Kind::PitchBend);
  CHECK(again.midi[3].fine);
}

TEST_CASE("rig: messages that events and controls send, and OSC addresses, read back the same", "[rig]") {
  const auto rig = rig_of(kDesk + R"(
[midi_out]
hit      = { note = 38, channel = 10, softest = "-60 dB", loudest = 0.5, length = "20 ms" }
toss     = { note = 39 }
strength = { control = 7 }
rate     = { clock = true, per_beat = 4 }
[osc]
strength = { address = "/1/fader3" }
[hid]
strength = { device = "Pedal", axis = 1, invert = true }
sensitivity = { button = 3 }
)");
  REQUIRE(rig.midi_out.size() == 4);
  CHECK(rig.midi_out[0].channel == 10);
  CHECK(rig.midi_out[0].number == 38);
  CHECK(rig.midi_out[0].softest == Approx(0.001));
  CHECK(rig.midi_out[0].loudest == 0.5);
  CHECK(rig.midi_out[0].length == 20_ms);
  CHECK(rig.midi_out[1].channel == 1);
  CHECK(rig.midi_out[1].softest == Approx(0.01));
  CHECK(rig.midi_out[2].kind == RigMidiOut::Kind::Controller);
  CHECK(rig.midi_out[3].kind == RigMidiOut::Kind::Clock);
  CHECK(rig.midi_out[3].per_beat == 4);
  REQUIRE(rig.osc.size() == 1);
  CHECK(rig.osc[0].address == "/1/fader3");
  REQUIRE(rig.hid.size() == 2);
  CHECK(rig.hid[0].device == "Pedal");
  CHECK(rig.hid[0].number == 1);
  CHECK(rig.hid[0].invert);
  CHECK(rig.hid[1].part == HidPart::Button);
  const auto text = to_text(rig);
  INFO(text);
  CHECK(to_text(rig_of(text)) == text);
  CHECK(rig_of(text).midi_out[0].softest == rig.midi_out[0].softest);
}

TEST_CASE("rig: wrong messages and addresses are errors with their place", "[rig]") {
  const auto errors = [](const std::string& lines) {
    const auto read = parse_rig("format = 1\n[device]\noutput = \"x\"\n" + lines, "rig.toml", kProfiles);
    return read ? "" : to_string(read.error());
  };
  CHECK(errors("[midi_out]\nhit = { channel = 2 }\n") ==
        "rig.toml:5:1: 'hit' needs exactly one of 'note', 'control' and 'clock'; give one of note = 38, "
        "control = 7 and "
        "clock = true");
  CHECK(errors("[midi_out]\nhit = { note = 38, softest = 0.5, loudest = 0.1 }\n")
            .find("the softest level of 'hit' is not below the loudest") != std::string::npos);
  CHECK(errors("[midi_out]\na = { control = 7, length = \"1 s\" }\n").find("only allowed with 'note'") !=
        std::string::npos);
  CHECK(errors("[hid]\na = { axis = 1, button = 2 }\n").find("needs an axis or a button") !=
        std::string::npos);
  for (const auto* wrong : {"fader", "/a b", "/fader*", "/mute", "/control/a"}) {
    INFO(wrong);
    CHECK(errors(std::string{"[osc]\na = { address = \""} + wrong + "\" }\n").find("rig.toml:5:17") !=
          std::string::npos);
  }
  CHECK(errors("[osc]\na = { address = \"/x\" }\nb = { address = \"/x\" }\n")
            .find("moves another control already") != std::string::npos);
  CHECK(errors("[osc]\na = { address = \"fader\" }\n").find("is no OSC address") != std::string::npos);
}

TEST_CASE("rig: sensitivities of every dimension read back the same", "[rig]") {
  const auto* sensitivity =
      GENERATE("50 mV", "-50 mV", "3.3 V/m", "12 mV/N", "100 mV s^2/m", "2 V s/m", "0.7 mV/Pa", "0.25");
  auto rig = rig_of(kDesk);
  const auto quantity = read_quantity(Value{std::string{sensitivity}, {}});
  REQUIRE(quantity);
  rig.inputs[0].sensitivity = *quantity;
  const auto text = to_text(rig);
  INFO(text);
  const auto again = rig_of(text);
  CHECK(again.inputs[0].sensitivity->si == quantity->si);
  CHECK(again.inputs[0].sensitivity->unit.dimension == quantity->unit.dimension);
}

TEST_CASE("rig: names that are no bare keys are written in quotes and read back", "[rig]") {
  const auto* name =
      GENERATE("my shaker", "x = { channel = 4 } #", "a.b", "", "Gerät", "\"'\\", "bare-key_1");
  CAPTURE(name);
  auto rig = rig_of(kDesk);
  rig.inputs[0].name = rig.outputs[0].name = rig.actuators[0].name = name;
  rig.controls[0].name = rig.midi[0].control = name;
  const auto text = to_text(rig);
  INFO(text);
  const auto again = rig_of(text);
  CHECK(to_text(again) == text);
  CHECK(again.inputs[0].name == name);
  CHECK(again.outputs[0].name == name);
  CHECK(again.actuators[0].name == name);
  CHECK(again.controls[0].name == name);
  CHECK(again.midi[0].control == name);
}

TEST_CASE("rig: an empty device id is refused, as it would be the default card", "[rig]") {
  const auto errors = [](const std::string& ids) {
    return test::summary(parse_rig("format = 1\n[device]\n" + ids, "rig.toml", kProfiles));
  };
  CHECK(errors("output = \"\"\n") == "rig.toml:3:10 Missing 'output' [device] `tactus devices`");
  CHECK(errors("output = \"x\"\ninput = \"\"\n") == "rig.toml:4:9 Missing 'input' [device] `tactus devices`");
}

TEST_CASE("rig: all errors of a rig come in one go", "[rig]") {
  CHECK(errors_of(R"([inputs]
microphone = { chanel = 1 }
piezo = { channel = 0, volts_per_full_scale = "1 V" }
[outputs]
woofer = { channel = 1.5, profile = "wofer", volts_per_full_scale = "10 V" }
[midi]
strength = { channel = 17, control = 7, note = 36 }
[delay]
measured = "12 mm"
)") ==
        R"(rig.toml:5:1 Missing 'microphone' 'channel' 'channel' 1 "none"
rig.toml:5:16 UnknownName 'chanel' 'channel'
rig.toml:6:1 Missing 'piezo' 'sensitivity' 'sensitivity' 'volts_per_full_scale'
rig.toml:6:21 OutOfRange 0 1 "none"
rig.toml:8:22 OutOfRange 1 "none"
rig.toml:8:37 UnknownName 'wofer' 'woofer'
rig.toml:10:1 Missing 'strength' 'control' 'note' 'pitch_bend' control 7 note 36 pitch_bend
rig.toml:10:24 OutOfRange 'channel' 17 1 16
rig.toml:12:12 UnitMismatch '12 mm' 'measured' "15 ms")");
  CHECK(test::summary(parse_rig("format = 1\n", "rig.toml", kProfiles)) ==
        "rig.toml:1:1 Missing [device] [device] `tactus devices`");
}

TEST_CASE("rig: two outputs never share a channel, nor has a channel two actuators", "[rig]") {
  CHECK(errors_of("[outputs]\na = { channel = [1, 2] }\nb = { channel = 2 }\n") ==
        "rig.toml:6:1 Duplicate 'b' 'a' 2");
  CHECK(errors_of(R"([outputs]
a = { channel = 2, profile = "woofer", volts_per_full_scale = "10 V" }
[actuators]
cone = { channel = 2 }
)") == "rig.toml:5:1 Duplicate 'a' 'cone' [actuators]");
  CHECK(errors_of("[actuators]\ncone = { channel = \"none\" }\n") == "rig.toml:5:1 Missing 'cone'");
}

TEST_CASE("rig: a file may lower the ceiling of an actuator and never raise it", "[rig]") {
  CHECK(errors_of("[actuators]\na = { channel = 2, ceiling = 0.9 }\n") ==
        "rig.toml:5:30 OutOfRange [actuators] 0.5 --raise-limit 0.9");
  CHECK(errors_of("[outputs]\na = { channel = 2, ceiling = 0.9, profile = \"woofer\", volts_per_full_scale = "
                  "\"100 V\" }\n") == "rig.toml:5:30 OutOfRange [outputs] 0.2 --raise-limit 0.9");
  const std::string ports = "[inputs]\nmicrophone = { channel = 1 }\n[outputs]\n";
  CHECK(
      misfits(ports + "woofer = { channel = 1, ceiling = 0.9 }\nsound = { channel = 2, ceiling = 0.9 }\n") ==
      "rig.toml:7:35 OutOfRange [outputs] 0.5 --raise-limit 0.9");
  // What hangs on the channel decides.
  CHECK(misfits(ports +
                "woofer = { channel = 1, ceiling = 0.9 }\nsound = { channel = 2 }\n[actuators]\ncone = { "
                "channel = 1, profile = \"woofer\", volts_per_full_scale = \"10 V\" }\n")
            .empty());
}

TEST_CASE("rig: what fits the drum passes, lacking ports and wrong names are errors", "[rig]") {
  CHECK(to_string(check_rig(rig_of(kDesk), *drum())).empty());
  CHECK(misfits(R"([inputs]
microfone = { channel = 1 }
[outputs]
woofer = { channel = "none" }
[controls]
strength = 1.5
hold = "15 mm"
[midi]
strenght = { control = 7 }
)") ==
        R"(rig.toml:1:1 Missing 'microphone' [inputs] microphone channel 1 channel "none"
rig.toml:1:1 Missing 'sound' [outputs] sound channel 1 channel "none"
rig.toml:5:1 UnknownName 'microfone' 'microphone'
rig.toml:9:12 OutOfRange 'strength' 1.5 0 1
rig.toml:10:8 UnitMismatch 'hold' 15
rig.toml:12:1 UnknownName 'strenght' 'strength')");
}

TEST_CASE("rig: sound never goes to a channel with an actuator", "[rig]") {
  const std::string inputs = "[inputs]\nmicrophone = { channel = 1 }\n[outputs]\nwoofer = { channel = 1 }\n";
  CHECK(misfits(inputs + "sound = { channel = 2 }\n[actuators]\nshaker = { channel = 2 }\n") ==
        "rig.toml:8:1 BadArgument 'sound' 2");
  CHECK(misfits(inputs + "sound = { channel = 2, profile = \"woofer\", volts_per_full_scale = \"1 V\" }\n") ==
        "rig.toml:8:1 BadArgument 'sound' 2");
}

TEST_CASE("rig: the unit of a sensitivity fits its port", "[rig]") {
  const auto graph = parse_graph(R"(format = 1
[inputs]
force = { unit = "N" }
pair = { lanes = 2 }
[outputs]
out = { from = "force / 1 N" }
)",
                                 "i.toml");
  REQUIRE(graph);
  const auto unit_errors = [&](const std::string& force) {
    return test::summary(
        check_rig(rig_of("format = 1\n[device]\noutput = \"x\"\n[inputs]\npair = { channel = [3, 4] "
                         "}\nforce = { channel = 1" +
                         force + " }\n[outputs]\nout = { channel = 1 }\n"),
                  **graph));
  };
  const std::string volts = ", volts_per_full_scale = \"2 V\", sensitivity = ";
  CHECK(unit_errors(volts + "\"50 mV/N\"").empty());
  CHECK(unit_errors(volts + "\"50 mV\"") == R"(rig.toml:6:68 UnitMismatch 'force' 1 "2 V/N")");
  CHECK(unit_errors("") == R"(rig.toml:6:1 Missing 'force' 1 "2 V/N")");
}

TEST_CASE("rig: an instrument's channels lie on those of the card that the rig names", "[rig]") {
  const auto rig = rig_of(R"(format = 1
[device]
output = "x"
[inputs]
microphone = { channel = 5, volts_per_full_scale = "1 V", sensitivity = "50 mV" }
[outputs]
sound = { channel = 2 }
woofer = { channel = 7 }
[actuators]
cone = { channel = 7, profile = "woofer", volts_per_full_scale = "10 V" }
)");
  const auto schedule = compile(*without_left_out(rig, drum()), standard_nodes(), {});
  REQUIRE(schedule);
  const auto wiring = wire_rig(rig, **schedule);
  REQUIRE(wiring);
  CHECK(wiring->in_map == std::vector{4});
  CHECK(wiring->out_map == std::vector{6, 1});  // woofer, sound: the order of the instrument
  CHECK(wiring->input_scales[0] == Approx(20));
  const auto guards = guarded_channels(**schedule, wiring->limits);
  REQUIRE(guards.size() == 2);
  CHECK(guards[0].limits.heat->watts_at_full_scale == Approx(100 / 6.5));  // of what hangs on channel 7
  CHECK(guards[1].kind == DriveGuard::Kind::Audio);
}

TEST_CASE("rig: the limits of [actuators] and [outputs] combine, for drives and for sound", "[rig]") {
  const auto guards = [](const std::string& woofer, const std::string& sound, const std::string& cone) {
    const auto rig = rig_of(
        "format = 1\n[device]\noutput = \"x\"\n[inputs]\nmicrophone = { channel = 1 }\n"
        "[outputs]\nwoofer = { channel = 7" +
        woofer + " }\nsound = { channel = 2" + sound + " }\n[actuators]\ncone = { channel = 7" + cone +
        " }\n");
    CHECK(to_string(check_rig(rig, *drum())).empty());
    const auto schedule = compile(*without_left_out(rig, drum()), standard_nodes(), {});
    REQUIRE(schedule);
    return guarded_channels(**schedule, wire_rig(rig, **schedule)->limits);
  };
  const std::string profile = ", profile = \"woofer\", volts_per_full_scale = \"10 V\"";
  const auto lowered = guards(", ceiling = 0.05", ", ceiling = 0.1", profile);
  CHECK(lowered[0].limits.ceiling == 0.05);
  CHECK(lowered[0].limits.heat.has_value());
  CHECK(lowered[0].origins[0] == LimitOrigin{"ceiling", 0.05, "[outputs] woofer"});
  CHECK(lowered[0].origins[1].source ==
        "profile 'woofer' (" + kRoot + "/profiles/woofer.toml) of [actuators] cone");
  CHECK(lowered[1].kind == DriveGuard::Kind::Audio);
  CHECK(lowered[1].limits.ceiling == 0.1);
  CHECK(lowered[1].limits.soft_start > 0_s);
  const auto other = guards(", ceiling = 0.05", ", ceiling = 0.9", profile + ", ceiling = 0.03");
  CHECK(other[0].limits.ceiling == 0.03);
  CHECK(other[0].origins[0].source == "[actuators] cone");
  CHECK(other[1].limits.ceiling == 0.9);
  CHECK(guards("", "", "")[0].limits.ceiling == conservative_limits().ceiling);
  CHECK(guards("", "", "")[1].limits.ceiling == 1.0);
}

TEST_CASE("rig: what is left out is silent and rests, and takes with it what only it needed", "[rig]") {
  const auto rig = rig_of(R"(format = 1
[device]
output = "x"
[inputs]
microphone = { channel = "none" }
[outputs]
woofer = { channel = "none" }
sound = { channel = 3 }
)");
  CHECK(check_rig(rig, *drum()).empty());
  const auto schedule = compile(*without_left_out(rig, drum()), standard_nodes(), {});
  REQUIRE(schedule);
  CHECK((*schedule)->nodes.empty());
  const auto wiring = wire_rig(rig, **schedule);
  REQUIRE(wiring);
  CHECK(wiring->in_map.empty());
  CHECK(wiring->out_map == std::vector{2});
}

TEST_CASE("rig: the lanes of a port and its channels are as many", "[rig]") {
  const auto graph = parse_graph(R"(format = 1
[inputs]
pair = { lanes = 2 }
[outputs]
both = { from = "pair" }
)",
                                 "i.toml");
  REQUIRE(graph);
  const auto wire = [&](const std::string& in, const std::string& out) {
    const auto rig = rig_of("format = 1\n[device]\noutput = \"x\"\n[inputs]\npair = { channel = " + in +
                            " }\n[outputs]\nboth = { channel = " + out + " }\n");
    const auto schedule = compile(**graph, standard_nodes(), {});
    REQUIRE(schedule);
    return wire_rig(rig, **schedule);
  };
  const auto fine = wire("[4, 2]", "[1, 8]");
  REQUIRE(fine);
  CHECK(fine->in_map == std::vector{3, 1});
  CHECK(fine->out_map == std::vector{0, 7});
  CHECK(test::summary(wire("1", "[1, 2, 3]")) ==
        R"(rig.toml:5:1 OutOfRange 'pair' 2 1 channel 1 2
rig.toml:7:1 OutOfRange 'both' 2 3 channel 1 2)");
}

TEST_CASE("rig: the delay is padded from what was measured to what is asked for", "[rig]") {
  CHECK(*padding_frames(12.5_ms, 20_ms, 48_kHz, "--pad-delay") == 360);
  CHECK(*padding_frames(20_ms, 20_ms, 48_kHz, "--pad-delay") == 0);
  CHECK(test::summary(padding_frames(std::nullopt, 20_ms, 48_kHz, "--pad-delay")) ==
        R"(--pad-delay Missing [delay] measured "12.4 ms")");
  CHECK(test::summary(padding_frames(25_ms, 20_ms, 48_kHz, "--pad-delay")) == "--pad-delay OutOfRange 25 20");
}
