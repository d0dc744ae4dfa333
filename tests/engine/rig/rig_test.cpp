#include "engine/rig/rig.h"

#include <catch2/catch.hpp>

#include "engine/graph/file/load.h"
#include "engine/graph/plan/compile.h"
#include "engine/nodes/table.h"
#include "engine/rig/check_rig.h"
#include "engine/scene/guard_report.h"
#include "tests/support/messages.h"
#include "tests/support/parse_graph.h"

using namespace tactus;
using tactus::test::parse_graph;

namespace {

const std::string kRoot = std::string{TACTUS_SOURCE_DIR} + "/instruments";

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
  auto rig = parse_rig(text, "rig.toml", kRoot);
  INFO((rig ? "" : to_string(rig.error())));
  REQUIRE(rig);
  return *rig;
}

/// With the least that a rig must say before them.
test::Messages mistakes(const std::string& lines) {
  const auto rig = parse_rig("format = 1\n[device]\noutput = \"x\"\n" + lines, "rig.toml", kRoot);
  return rig ? "" : to_string(rig.error());
}

std::shared_ptr<const GraphSpec> drum() {
  static const auto graph = load_graph(kRoot + "/haptic_drum/instrument.toml", kRoot);
  REQUIRE(graph);
  return *graph;
}

test::Messages misfits(const std::string& lines) {
  const auto rig = rig_of("format = 1\n[device]\noutput = \"x\"\n" + lines);
  return to_string(check_rig(rig, *drum()));
}

}  // namespace

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
  CHECK(rig.outputs[0].drive.limits.ceiling == 0.8);
  CHECK(rig.outputs[0].drive.limits.heat->watts_at_full_scale == Approx(100 / 6.5));  // V^2 / R
  CHECK(rig.outputs[1].drive.limits.ceiling == conservative_limits().ceiling);
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
  CHECK(again.midi[1].gate);
  CHECK(again.midi[2].kind == RigMidi::Kind::PitchBend);
  CHECK(again.midi[3].fine);
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

TEST_CASE("rig: all mistakes of a rig come in one go", "[rig]") {
  CHECK(
      mistakes(R"([inputs]
microphone = { chanel = 1 }
piezo = { channel = 0, volts_per_full_scale = "1 V" }
[outputs]
woofer = { channel = 1.5, profile = "wofer", volts_per_full_scale = "10 V" }
[midi]
strength = { channel = 17, control = 7, note = 36 }
[delay]
measured = "12 mm"
)") ==
      R"(rig.toml:5:1: input 'microphone' lacks 'channel'; give 'channel': channel of the card, counted from 1, one per lane; "none" leaves the port unconnected
rig.toml:5:16: unknown key 'chanel'; did you mean 'channel'?
rig.toml:6:1: input 'piezo' lacks 'sensitivity'; give both 'sensitivity' and 'volts_per_full_scale', or neither
rig.toml:6:21: there is no channel 0; channels are counted from 1; "none" leaves the port unconnected
rig.toml:8:22: a channel must be a whole number, not a number; channels are counted from 1; "none" leaves the port unconnected
rig.toml:8:37: there is no profile 'wofer'; did you mean 'woofer'?
rig.toml:10:1: control 'strength' needs exactly one MIDI source; give one of control = 7, note = 36 and pitch_bend = true
rig.toml:10:24: 'channel' cannot be 17; give one from 1 to 16
rig.toml:12:12: '12 mm' is in m, but 'measured' is in s; give "15 ms")");
  CHECK(
      to_string(parse_rig("format = 1\n", "rig.toml", kRoot).error()) ==
      "rig.toml:1:1: the rig lacks [device]; give [device]: the sound device, as listed by `tactus devices`");
}

TEST_CASE("rig: two outputs never share a channel, nor has a channel two actuators", "[rig]") {
  CHECK(mistakes("[outputs]\na = { channel = [1, 2] }\nb = { channel = 2 }\n") ==
        "rig.toml:6:1: outputs 'b' and 'a' share channel 2; give each its own channel");
  CHECK(mistakes(R"([outputs]
a = { channel = 2, profile = "woofer", volts_per_full_scale = "10 V" }
[actuators]
cone = { channel = 2 }
)") == "rig.toml:5:1: the actuator of 'a' is also 'cone' in [actuators]; declare it once");
  CHECK(mistakes("[actuators]\ncone = { channel = \"none\" }\n") ==
        "rig.toml:5:1: actuator 'cone' has no channel; give its channel, or remove it");
}

TEST_CASE("rig: a file may lower the ceiling of an actuator and never raise it", "[rig]") {
  CHECK(mistakes("[outputs]\na = { channel = 2, ceiling = 0.9 }\n") ==
        "rig.toml:5:30: a file cannot raise a limit: the ceiling of 'a' is 0.5; lower it, or use "
        "--raise-limit ceiling=0.9 on the command line");
}

TEST_CASE("rig: what fits the drum is found good, lacking ports and wrong names are told", "[rig]") {
  CHECK(to_string(check_rig(rig_of(kDesk), *drum())).empty());
  CHECK(
      misfits(R"([inputs]
microfone = { channel = 1 }
[outputs]
woofer = { channel = "none" }
[controls]
strength = 1.5
hold = "15 mm"
[midi]
strenght = { control = 7 }
)") ==
      R"(rig.toml:1:1: input 'microphone' of the instrument has no channel; under [inputs], write microphone = { channel = 1 }, or { channel = "none" } to leave it unconnected
rig.toml:1:1: output 'sound' of the instrument has no channel; under [outputs], write sound = { channel = 1 }, or { channel = "none" } to leave it unconnected
rig.toml:5:1: the instrument has no input 'microfone'; did you mean 'microphone'?
rig.toml:9:12: 'strength' cannot be 1.5; it runs from 0 to 1
rig.toml:10:8: 'hold' is set in m, but it is in s; give for instance 15 ms
rig.toml:12:1: the instrument has no control 'strenght'; did you mean 'strength'?)");
}

TEST_CASE("rig: sound never goes to a channel with an actuator", "[rig]") {
  const std::string inputs = "[inputs]\nmicrophone = { channel = 1 }\n[outputs]\nwoofer = { channel = 1 }\n";
  CHECK(misfits(inputs + "sound = { channel = 2 }\n[actuators]\nshaker = { channel = 2 }\n") ==
        "rig.toml:8:1: 'sound' is an audio output, but channel 2 drives an actuator; audio outputs have "
        "weaker limits than drives; use another channel, or make this output a drive in the instrument");
  CHECK(misfits(inputs + "sound = { channel = 2, profile = \"woofer\", volts_per_full_scale = \"1 V\" }\n") ==
        "rig.toml:8:1: 'sound' is an audio output, but channel 2 drives an actuator (woofer); audio outputs "
        "have weaker limits than drives; use another channel, or make this output a drive in the instrument");
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
  const auto told = [&](const std::string& force) {
    return to_string(
        check_rig(rig_of("format = 1\n[device]\noutput = \"x\"\n[inputs]\npair = { channel = [3, 4] "
                         "}\nforce = { channel = 1" +
                         force + " }\n[outputs]\nout = { channel = 1 }\n"),
                  **graph));
  };
  const std::string volts = ", volts_per_full_scale = \"2 V\", sensitivity = ";
  CHECK(told(volts + "\"50 mV/N\"").empty());
  CHECK(told(volts + "\"50 mV\"") ==
        "rig.toml:6:68: the sensitivity of 'force' must be in V/N; give the voltage for 1 N, such as \"2 "
        "V/N\"");
  CHECK(told("") ==
        "rig.toml:6:1: 'force' is in N, but its voltage is not given; give volts_per_full_scale, "
        "and as sensitivity the voltage for 1 N, such as \"2 V/N\"");
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
  const auto guards = guarded_channels(**schedule, wiring->drives);
  REQUIRE(guards.size() == 2);
  CHECK(guards[0].limits.heat->watts_at_full_scale == Approx(100 / 6.5));  // of what hangs on channel 7
  CHECK(guards[1].kind == DriveGuard::Kind::Audio);
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
  CHECK(
      to_string(wire("1", "[1, 2, 3]").error()) ==
      "rig.toml:5:1: 'pair' has 2 lanes, but 1 channel; give one channel per lane, as in channel = [1, 2]\n"
      "rig.toml:7:1: 'both' has 2 lanes, but 3 channels; give one channel per lane, as in channel = [1, 2]");
}

TEST_CASE("rig: the delay is padded from what was measured to what is asked for", "[rig]") {
  CHECK(*padding_frames(12.5_ms, 20_ms, 48_kHz, "--pad-delay") == 360);
  CHECK(*padding_frames(20_ms, 20_ms, 48_kHz, "--pad-delay") == 0);
  CHECK(to_string(padding_frames(std::nullopt, 20_ms, 48_kHz, "--pad-delay").error()) ==
        "--pad-delay: the delay of this device has not been measured, so it cannot be extended; measure "
        "it with tactus latency measure, or write it into the rig: [delay] measured = \"12.4 ms\"");
  CHECK(to_string(padding_frames(25_ms, 20_ms, 48_kHz, "--pad-delay").error()) ==
        "--pad-delay: the delay of the device itself is 25 ms, longer than 20 ms; request a longer delay, or "
        "use smaller blocks");
}
