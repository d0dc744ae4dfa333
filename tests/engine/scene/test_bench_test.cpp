#include "engine/scene/test_bench.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/nodes/table.h"
#include "engine/scene/play_scene.h"

// An instrument alone on signal generators.

using namespace tactus;
using Kind = BenchInputs::Kind;

namespace {

constexpr const char* kInstrument = R"(
format = 1
name = "three inputs"
[inputs]
mic = { unit = "full scale" }
knob = { unit = "m" }
fingers = { unit = "N", lanes = 3 }
[nodes]
sum = { type = "mix", in = "fingers" }
[outputs]
drive = { from = "mic" }
place = { from = "knob / 1 m" }
force = { from = "fingers / 1 N" }
both = { from = "sum / 1 N" }
)";

LoadedScene bench(const std::string& text, const BenchInputs& inputs, Seconds duration = 2_s) {
  return scene_around(parse_graph_leniently(text, "three.toml"), inputs, 48_kHz, duration);
}

SceneRecording play(const std::string& text, const BenchInputs& inputs, bool by_hand = false) {
  const auto loaded = bench(text, inputs);
  REQUIRE(loaded.errors.empty());
  SceneOptions options;
  options.by_hand = by_hand;
  auto built = build_scene(loaded, standard_nodes(), options);
  if (!built) FAIL(to_string(built.error()));
  auto recording = play_scene(*loaded.scene, *built, 64);
  REQUIRE(recording);
  return std::move(*recording);
}

double peak(const SceneRecording& recording, const char* name, double from_s, double to_s) {
  const auto* signal = recording.find(name);
  REQUIRE(signal != nullptr);
  double most = 0;
  for (auto n = std::lround(from_s * 48e3); n < std::lround(to_s * 48e3); ++n)
    most = std::max(most, std::abs(signal->samples[static_cast<std::size_t>(n)]));
  return most;
}

}  // namespace

TEST_CASE("test bench: strikes every half second, and a motion where an input has a unit", "[scene]") {
  const auto recording = play(kInstrument, {});
  CHECK(recording.faults.empty());
  for (const double at : {0.0, 0.5, 1.0, 1.5}) {
    INFO(at);
    // Of 48 independent values in the first millisecond, where the burst is above 0.36 of 0.5.
    CHECK(peak(recording, "instrument.mic", at, at + 1e-3) > 0.2);
    CHECK(peak(recording, "instrument.mic", at, at + 1e-3) <= 0.5 * 1.0002);
    // e^(-100 ms / 3 ms) is below the noise of -80 dBFS.
    CHECK(peak(recording, "instrument.mic", at + 0.1, at + 0.49) <= 1.001e-4);
  }
  // 10 mm sin(2 pi 0.5 Hz t): greatest at 0.5 s, zero at 1 s. A sensor is quantised to 24 bits.
  const auto& knob = recording.find("instrument.knob")->samples;
  CHECK(knob[24000] == Approx(10e-3).margin(1e-6));
  CHECK(knob[48000] == Approx(0).margin(1e-6));
  CHECK(knob[72000] == Approx(-10e-3).margin(1e-6));
  CHECK(recording.find("instrument.knob")->dimension == Dimension{.metre = 1});
}

TEST_CASE("test bench: every lane of an input gets the signal, and lanes of outputs go nowhere", "[scene]") {
  const auto recording = play(kInstrument, {});
  CHECK(recording.inputs ==
        std::vector<std::string>{"mic", "knob", "fingers[0]", "fingers[1]", "fingers[2]"});
  CHECK(recording.outputs.size() == 6);
  const auto& lanes = recording.find("instrument.fingers[0]")->samples;
  CHECK(lanes == recording.find("instrument.fingers[2]")->samples);
  CHECK(*std::ranges::max_element(lanes) == Approx(1).margin(1e-6));
}

TEST_CASE("test bench: silence is zero, and no sensor is taken for a stuck one", "[scene]") {
  const auto recording = play(kInstrument, {.kind = Kind::Silence});
  for (const auto& input : recording.inputs)
    CHECK(std::ranges::count_if(recording.find("instrument." + input)->samples,
                                [](double sample) { return sample != 0; }) == 0);
  CHECK_FALSE(recording.guard.faded());
  CHECK_FALSE(play(kInstrument, {}).guard.faded());
  CHECK_FALSE(play(kInstrument, {.kind = Kind::Keyboard}, /*by_hand=*/true).guard.faded());
}

TEST_CASE("test bench: names of an instrument may be those of the generators", "[scene]") {
  const auto recording = play(
      "format = 1\n[inputs]\nstrike = {}\nbeats = {}\nbench_noise = {}\n[outputs]\no = { from = \"strike + "
      "beats + "
      "bench_noise\" }\n",
      {}, /*by_hand=*/true);
  CHECK(peak(recording, "instrument.strike", 0, 1e-3) > 0.2);
  CHECK(peak(recording, "instrument.bench_noise", 0, 1e-3) > 0.2);
}

TEST_CASE("test bench: what the inputs receive is described by input", "[scene]") {
  const auto graph = parse_graph_leniently(kInstrument, "three.toml");
  CHECK(describe({}, *graph.spec) ==
        "2 strikes per second at mic\na sine of 0.5 Hz at knob (±10 mm), fingers (±1 N)");
  CHECK(describe({.kind = Kind::Silence}, *graph.spec) == "silence at mic, knob, fingers");
  CHECK(describe({Kind::File, "hits.wav", 2}, *graph.spec) == "hits.wav at mic, knob\nsilence at fingers");
  CHECK(describe({}, GraphSpec{}).empty());
}

// Keys 60, 64, 67 and 72, one every half second, each with its trigger 10 ms later and its end 0.4 s after
// that.
TEST_CASE("test bench: controls that keyboards set receive notes", "[scene]") {
  constexpr const char* kKeyboard = R"(
format = 1
name = "keys"
[controls]
key = { value = 69, range = [0, 127], midi = "note" }
loud = { value = 0, range = [0, 1], midi = "velocity" }
down = { value = 0, range = [0, 1], midi = "note_on" }
up = { value = 0, range = [0, 1], midi = "note_off" }
[nodes]
begins = { type = "counter", trigger = "down" }
ends = { type = "counter", trigger = "up" }
[outputs]
key = { from = "key / 1000" }
loud = { from = "loud / 10" }
begins = { from = "begins / 100" }
ends = { from = "ends / 100" }
)";
  const auto graph = parse_graph_leniently(kKeyboard, "keys.toml");
  CHECK(describe({}, *graph.spec) == "no notes");
  CHECK(describe({.notes = true}, *graph.spec) == "2 notes per second as from a keyboard");
  const auto recording = play(kKeyboard, {.notes = true});
  const auto at = [&](const char* name, double time_s) {
    return recording.find(name)->samples[static_cast<std::size_t>(std::lround(time_s * 48e3))];
  };
  const double keys[] = {60, 64, 67, 72};
  for (int note = 0; note < 4; ++note) {
    INFO(note);
    CHECK(at("instrument.key", 0.5 * note + 0.2) == Approx(keys[note] / 1000).margin(1e-6));
    CHECK(at("instrument.loud", 0.5 * note + 0.2) == Approx(0.07).margin(1e-6));
    CHECK(at("instrument.begins", 0.5 * note + 0.2) == Approx(0.01 * (note + 1)).margin(1e-6));
    CHECK(at("instrument.ends", 0.5 * note + 0.45) == Approx(0.01 * (note + 1)).margin(1e-6));
  }
}

TEST_CASE("test bench: the errors are those of the instrument", "[scene]") {
  const auto loaded = bench("format = 1\n[outputs]\no = { from = 7, kind = \"odour\" }\n", {});
  REQUIRE_FALSE(loaded.errors.empty());
  for (const auto& error : loaded.errors) CHECK(error.where.starts_with("three.toml:3:"));
}
