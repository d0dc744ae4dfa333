#include <catch2/catch.hpp>
#include <filesystem>

#include "engine/nodes/table.h"
#include "engine/scene/build_scene.h"
#include "tests/support/messages.h"
#include "tests/support/scene_folder.h"

using namespace tactus;

namespace {

struct BadFile {
  const char* what;
  std::string text;
  std::string told;
};

// clang-format off
const BadFile kBadFiles[] = {
    {"no duration",
     R"(format = 1
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:1:1: 'duration' is missing; give the length of the scene, as in duration = "6 s")"},
    {"a duration of nothing",
     R"(format = 1
duration = "0 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:2:12: 'duration' cannot be 0 s; it runs from 1 ms to 86400 s)"},
    {"a duration of a year",
     R"(format = 1
duration = "31536000 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:2:12: 'duration' cannot be 3.1536e+07 s; it runs from 1 ms to 86400 s)"},
    {"a delay in metres",
     R"(format = 1
duration = "1 s"
delay = "3 m"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:3:9: '3 m' is in m, but 'delay' is in s; give "15 ms")"},
    {"a negative delay",
     R"(format = 1
duration = "1 s"
delay = "-1 ms"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:3:9: 'delay' cannot be -1 ms; it runs from 0 s to 10 s)"},
    {"a rate that no card has",
     R"(format = 1
duration = "1 s"
rate = "10 Hz"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:3:8: 'rate' cannot be 10 Hz; it runs from 1 kHz to 768 kHz)"},
    {"a seed with a point",
     R"(format = 1
duration = "1 s"
seed = 1.5
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:3:8: 'seed' must be a whole number; give one from 0 to 9007199254740991)"},
    {"an unknown key",
     R"(format = 1
duration = "1 s"
speed = 2
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:3:1: unknown key 'speed'; did you mean 'seed'?)"},
    {"a graph's section in a scene",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[nodes]
a = 1
)",
     R"(scene.toml:6:2: 'nodes' is a key of graphs, but this is a scene; move it to the file of a part)"},
    {"no plant",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = 0, pedal = 0 }
)",
     R"(scene.toml:3:1: the part 'plant' is missing; under [parts], write plant = { use = "plant.toml", … })"},
    {"a part in quotes",
     R"(format = 1
duration = "1 s"
[parts]
instrument = "instrument.toml"
plant = { use = "plant.toml", drive = 0, lift = 0 }
)",
     R"(scene.toml:4:14: 'instrument' in [parts] must be a table, not a string; write instrument = { use = "file.toml" })"},
    {"a part without a file",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { mic = 0, pedal = 0 }
plant = { use = "plant.toml", drive = 0, lift = 0 }
)",
     R"(scene.toml:4:1: part 'instrument' has no 'use'; give its file, as in use = "instrument.toml")"},
    {"a part whose file is not there",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrumnet.toml", mic = 0, pedal = 0 }
plant = { use = "plant.toml", drive = 0, lift = 0 }
)",
     R"(scene.toml:4:22: there is no file 'instrumnet.toml'; did you mean 'instrument.toml'?)"},
    {"a part from outside",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "../instrument.toml", mic = 0, pedal = 0 }
plant = { use = "/plant.toml", drive = 0, lift = 0 }
)",
     R"(scene.toml:4:22: '../instrument.toml' is outside the folder 'FOLDER'; keep the files of an instrument inside it
scene.toml:5:17: '/plant.toml' is an absolute path; give the path relative to this file)"},
    {"a part that is the scene itself",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "scene.toml" }
plant = { use = "plant.toml", drive = 0, lift = 0 }
)",
     R"(scene.toml:4:22: a scene cannot be a part of itself; give the file of a graph)"},
    {"a wire that stops",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic +", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:4:59: the expression is incomplete; write a number, a name or '(' here)"},
    {"a wire to nowhere",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mik", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:4:48: there is no 'plant.mik'; did you mean 'plant.mic'?)"},
    {"a wire of the wrong unit",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = "3 N" }
)",
     R"(scene.toml:5:68: 'lift' is in m, but this is in N; give a quantity in m)"},
    {"a wire to a part that is not there",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "piano.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:4:48: there is no 'piano.mic'; did you mean 'plant.mic'?)"},
    {"an input that is not wired",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = 0 }
plant = { use = "plant.toml", drive = 0 }
)",
     R"(scene.toml:4:1: input 'pedal' of the instrument is not connected; give its source, as in pedal = "plant.pedal"
scene.toml:5:1: part 'plant' lacks 'lift'; it is an input of plant.toml)"},
    {"a gesture without points",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = { curve = "step" }
)",
     R"(scene.toml:7:1: gesture 'hand' lacks 'points'; give 'points': [[time, value], …] with ascending times)"},
    {"a gesture that is a list",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = [[0, 1]]
)",
     R"(scene.toml:7:8: 'hand' in [gestures] must be a table, not a list; write hand = { points = [["0 s", 0], ["1 s", 1]] })"},
    {"a point with one number",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = { points = [["0 s"]] }
)",
     R"(scene.toml:7:20: a point must be a time and a value; write for instance ["0.1 s", "2 m/s"])"},
    {"a gesture that goes back in time",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = { points = [["0 s", 0], ["0.5 s", 1], ["20 ms", 0]] }
)",
     R"(scene.toml:7:47: 20 ms is not later than 500 ms before it; the times of a gesture must be ascending)"},
    {"a gesture before the beginning",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = { points = [["-5 ms", 0]] }
)",
     R"(scene.toml:7:21: the time of a point cannot be -5 ms; use times between 0 s and one day)"},
    {"a gesture in two units",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = { points = [["0 s", "0 mm"], ["1 s", "1 N"]] }
)",
     R"(scene.toml:7:45: '1 N' is in N, but 'hand' is in m; give "12 mm")"},
    {"an unknown curve",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = { points = [["0 s", 0]], curve = "smoth" }
)",
     R"(scene.toml:7:41: 'curve' cannot be 'smoth'; did you mean 'smooth'?)"},
    {"a gesture called like a part",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
plant = { points = [["0 s", 0]] }
)",
     R"(scene.toml:7:1: 'plant' cannot name a gesture: it names a part in line 5; choose another name)"},
    {"a gesture beyond a control's range",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0, strength = "rise" }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
rise = { points = [["0 s", 0], ["1 s", 3]] }
)",
     R"(scene.toml:4:82: control 'strength' cannot be set to 3 by gesture 'rise'; it runs from 0 to 1)"},
    {"a control beyond its range",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0, strength = 7 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:4:82: control 'strength' cannot be set to 7; it runs from 0 to 1)"},
    {"too many bits",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[converters]
bits = 64
)",
     R"(scene.toml:7:8: 'bits' cannot be 64; give one from 1 to 32)"},
    {"converters off and with bits",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[converters]
off = true
bits = 16
)",
     R"(scene.toml:7:7: 'bits' has no effect while the converters are 'off'; remove 'off' or 'bits')"},
    {"converters off in quotes",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[converters]
off = "yes"
)",
     R"(scene.toml:7:7: 'off' must be true or false, not a string; write off = true)"},
    {"an expectation of nothing",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "rate", of = "instrument.hit" }
)",
     R"(scene.toml:7:1: expectation 'roll' lacks 'min' and 'max'; give at least one of them)"},
    {"an expectation without a measure",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { of = "instrument.hit", min = 1 }
)",
     R"(scene.toml:7:1: expectation 'roll' lacks 'measure'; give 'measure': name of a measure)"},
    {"an unknown measure",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "rat", of = "instrument.hit", min = 1 }
)",
     R"(scene.toml:7:20: 'measure' cannot be 'rat'; did you mean 'rate'?)"},
    {"a measure of nothing recorded",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "rate", of = "instrument.hti", min = 1 }
)",
     R"(scene.toml:7:33: no signal 'instrument.hti' is recorded; did you mean 'instrument.hit'?)"},
    {"limits upside down",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "rate", of = "instrument.hit", min = "16 Hz", max = "14 Hz" }
)",
     R"(scene.toml:7:72: 'max' is below 'min'; swap them)"},
    {"limits in two units",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "peak", of = "plant.stick", min = "1 mm", max = "1 s" }
)",
     R"(scene.toml:7:68: 'min' and 'max' are in different units; give both in the same unit)"},
    {"limits in the wrong unit",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "count", of = "instrument.hit", max = "3 ms" }
)",
     R"(scene.toml:7:1: 'count' is a plain number, but it is compared with 3 ms; omit the unit)"},
    {"an end after the end",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "rate", of = "instrument.hit", to = "5 s", min = 1 }
)",
     R"(scene.toml:7:56: 'to' cannot be 5 s; it runs from 0 s to 1 s)"},
    {"from after to",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "rate", of = "instrument.hit", from = "800 ms", to = "200 ms", min = 1 }
)",
     R"(scene.toml:7:73: 'to' is not later than 'from'; swap them)"},
    {"strikes without a contact",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "missed", max = 0 }
)",
     R"(scene.toml:7:1: 'missed' needs a signal with the role 'contact'; give one under [roles], as in contact = "plant.contact")"},
    {"a comparison without a name",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[compare]
strength = 0
)",
     R"(scene.toml:6:1: [compare] lacks 'name'; add a name, such as name = "without the pulse")"},
    {"a comparison of a control that is not there",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[compare]
name = "soft"
strenght = 0
)",
     R"(scene.toml:8:1: part 'instrument' has no control 'strenght'; did you mean 'strength'?)"},
    {"a comparison of a part that is not there",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[compare]
name = "soft"
piano.gain = 0
)",
     R"(scene.toml:8:7: there is no part 'piano'; see [parts])"},
    {"a comparison beyond the range",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[compare]
name = "soft"
strength = 9
)",
     R"(scene.toml:8:1: control 'strength' cannot be set to 9; it runs from 0 to 1)"},
};
// clang-format on

}  // namespace

TEST_CASE("bad files: a scene that is wrong says where, what, and what to do", "[scene]") {
  const test::SceneFolder folder;
  for (const auto& file : kBadFiles) {
    INFO(file.what);
    folder.write("scene.toml", file.text);
    const auto built = build_scene(load_scene_leniently(folder.path() / "scene.toml"), standard_nodes());
    auto told = built ? "" : folder.strip(to_string(built.error()));
    const auto name = folder.path().filename().string();
    if (const auto at = told.find(name); at != std::string::npos) told.replace(at, name.size(), "FOLDER");
    CHECK(test::Messages{told} == file.told);
  }
}

TEST_CASE("hostile files: a scene is read as carefully as a graph", "[scene]") {
  const test::TemporaryFolder folder;
  const auto told = [&](std::string_view text, std::uintmax_t bytes = 0) -> test::Messages {
    const auto file = folder.write("scene.toml", text);
    if (bytes > 0) std::filesystem::resize_file(file, bytes);
    const auto built = build_scene(load_scene_leniently(file), standard_nodes());
    return built ? "" : folder.strip(to_string(built.error()));
  };
  CHECK(told("format = 1\n", 1u << 30) ==
        "scene.toml: the file is larger than 16 MB; split the file, or keep data in sound files");
  CHECK(told("format = 1\n\xff\xfe") == "scene.toml:2:1: this is not UTF-8 text; save the file as UTF-8");
  CHECK(told("parts = " + std::string(100000, '[')) ==
        "scene.toml:1:73: brackets or dots more than 64 deep; reduce the nesting");
  CHECK(told("duration = nan\n").find("scene.toml:1:12: inf and nan are not allowed; give a finite number") !=
        std::string::npos);
}
