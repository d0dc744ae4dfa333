#include <catch2/catch.hpp>
#include <filesystem>

#include "engine/nodes/table.h"
#include "engine/scene/build_scene.h"
#include "tests/support/error_summary.h"
#include "tests/support/scene_folder.h"

using namespace tactus;

namespace {

struct BadFile {
  const char* what;
  std::string text;
  std::string expected;
};

// clang-format off
const BadFile kBadFiles[] = {
    {"no duration",
     R"(format = 1
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:1:1 Missing 'duration' duration "6 s")"},
    {"a duration of nothing",
     R"(format = 1
duration = "0 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     "scene.toml:2:12 OutOfRange 'duration' 0 1 86400"},
    {"a duration of a year",
     R"(format = 1
duration = "31536000 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     "scene.toml:2:12 OutOfRange 'duration' 3.1536e+07 1 86400"},
    {"a delay in metres",
     R"(format = 1
duration = "1 s"
delay = "3 m"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     R"(scene.toml:3:9 UnitMismatch '3 m' 'delay' "15 ms")"},
    {"a negative delay",
     R"(format = 1
duration = "1 s"
delay = "-1 ms"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     "scene.toml:3:9 OutOfRange 'delay' -1 0 10"},
    {"a rate that no card has",
     R"(format = 1
duration = "1 s"
rate = "10 Hz"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     "scene.toml:3:8 OutOfRange 'rate' 10 1 768"},
    {"a seed with a point",
     R"(format = 1
duration = "1 s"
seed = 1.5
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     "scene.toml:3:8 OutOfRange 'seed' 0 9007199254740991"},
    {"an unknown key",
     R"(format = 1
duration = "1 s"
speed = 2
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     "scene.toml:3:1 UnknownName 'speed' 'seed'"},
    {"a graph's section in a scene",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[nodes]
a = 1
)",
     "scene.toml:6:2 UnknownName 'nodes'"},
    {"no parts",
     R"(format = 1
duration = "1 s"
[parts]
)",
     R"(scene.toml:3:1 Missing [parts] instrument use "instrument.toml")"},
    {"a part in quotes",
     R"(format = 1
duration = "1 s"
[parts]
instrument = "instrument.toml"
plant = { use = "plant.toml", drive = 0, lift = 0 }
)",
     R"(scene.toml:4:14 WrongType 'instrument' [parts] instrument use "file.toml")"},
    {"a part without a file",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { mic = 0, pedal = 0 }
plant = { use = "plant.toml", drive = 0, lift = 0 }
)",
     R"(scene.toml:4:1 Missing 'instrument' 'use' use "instrument.toml")"},
    {"a part whose file is not there",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrumnet.toml", mic = 0, pedal = 0 }
plant = { use = "plant.toml", drive = 0, lift = 0 }
)",
     "scene.toml:4:22 BadFile 'instrumnet.toml' 'instrument.toml'"},
    {"a part from outside",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "../instrument.toml", mic = 0, pedal = 0 }
plant = { use = "/plant.toml", drive = 0, lift = 0 }
)",
     R"(scene.toml:4:22 OutOfRange '../instrument.toml' 'FOLDER'
scene.toml:5:17 OutOfRange '/plant.toml')"},
    {"a part that is the scene itself",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "scene.toml" }
plant = { use = "plant.toml", drive = 0, lift = 0 }
)",
     "scene.toml:4:22 Cycle"},
    {"a wire that stops",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic +", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     "scene.toml:4:59 Syntax '('"},
    {"a wire to nowhere",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mik", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     "scene.toml:4:48 UnknownName 'plant.mik' 'plant.mic'"},
    {"a wire of the wrong unit",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = "3 N" }
)",
     "scene.toml:5:68 UnitMismatch 'lift'"},
    {"a wire to a part that is not there",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "piano.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     "scene.toml:4:48 UnknownName 'piano.mic' 'plant.mic'"},
    {"an input that is not wired",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = 0 }
plant = { use = "plant.toml", drive = 0 }
)",
     R"(scene.toml:4:1 Missing 'pedal' pedal "plant.pedal"
scene.toml:5:1 Missing 'plant' 'lift' plant.toml)"},
    {"a gesture without points",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = { curve = "step" }
)",
     "scene.toml:7:1 Missing 'hand' 'points' 'points'"},
    {"a gesture that is a list",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = [[0, 1]]
)",
     R"(scene.toml:7:8 WrongType 'hand' [gestures] hand points "0 s" 0 "1 s" 1)"},
    {"a point with one number",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = { points = [["0 s"]] }
)",
     R"(scene.toml:7:20 WrongType "0.1 s" "2 m/s")"},
    {"a gesture that goes back in time",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = { points = [["0 s", 0], ["0.5 s", 1], ["20 ms", 0]] }
)",
     "scene.toml:7:47 OutOfRange 20 500"},
    {"a gesture before the beginning",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = { points = [["-5 ms", 0]] }
)",
     "scene.toml:7:21 OutOfRange -5 0"},
    {"a gesture in two units",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = { points = [["0 s", "0 mm"], ["1 s", "1 N"]] }
)",
     R"(scene.toml:7:45 UnitMismatch '1 N' 'hand' "12 mm")"},
    {"an unknown curve",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
hand = { points = [["0 s", 0]], curve = "smoth" }
)",
     "scene.toml:7:41 UnknownName 'curve' 'smoth' 'smooth'"},
    {"a gesture called like a part",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
plant = { points = [["0 s", 0]] }
)",
     "scene.toml:7:1 Duplicate 'plant' 5"},
    {"a gesture beyond a control's range",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0, strength = "rise" }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[gestures]
rise = { points = [["0 s", 0], ["1 s", 3]] }
)",
     "scene.toml:4:82 OutOfRange 'strength' 3 'rise' 0 1"},
    {"a control beyond its range",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0, strength = 7 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
)",
     "scene.toml:4:82 OutOfRange 'strength' 7 0 1"},
    {"too many bits",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[converters]
bits = 64
)",
     "scene.toml:7:8 OutOfRange 'bits' 64 1 32"},
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
     "scene.toml:7:7 Duplicate 'bits' 'off' 'off' 'bits'"},
    {"converters off in quotes",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[converters]
off = "yes"
)",
     "scene.toml:7:7 WrongType 'off' off"},
    {"an expectation of nothing",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "rate", of = "instrument.hit" }
)",
     "scene.toml:7:1 Missing 'roll' 'min' 'max'"},
    {"an expectation without a measure",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { of = "instrument.hit", min = 1 }
)",
     "scene.toml:7:1 Missing 'roll' 'measure' 'measure'"},
    {"an unknown measure",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "rat", of = "instrument.hit", min = 1 }
)",
     "scene.toml:7:20 UnknownName 'measure' 'rat' 'rate'"},
    {"a measure of nothing recorded",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "rate", of = "instrument.hti", min = 1 }
)",
     "scene.toml:7:33 UnknownName 'instrument.hti' 'instrument.hit'"},
    {"limits upside down",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "rate", of = "instrument.hit", min = "16 Hz", max = "14 Hz" }
)",
     "scene.toml:7:72 OutOfRange 'max' 'min'"},
    {"limits in two units",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "peak", of = "plant.stick", min = "1 mm", max = "1 s" }
)",
     "scene.toml:7:68 UnitMismatch 'min' 'max'"},
    {"limits in the wrong unit",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "count", of = "instrument.hit", max = "3 ms" }
)",
     "scene.toml:7:1 UnitMismatch 'count' 3"},
    {"an end after the end",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "rate", of = "instrument.hit", to = "5 s", min = 1 }
)",
     "scene.toml:7:56 OutOfRange 'to' 5 0 1"},
    {"from after to",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "rate", of = "instrument.hit", from = "800 ms", to = "200 ms", min = 1 }
)",
     "scene.toml:7:73 OutOfRange 'to' 'from'"},
    {"strikes without a contact",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[expect]
roll = { measure = "missed", max = 0 }
)",
     R"(scene.toml:7:1 Missing 'missed' 'contact' [roles] contact "plant.contact")"},
    {"a comparison without a name",
     R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0 }
[compare]
strength = 0
)",
     R"(scene.toml:6:1 Missing [compare] 'name' name "without the pulse")"},
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
     "scene.toml:8:1 UnknownName 'instrument' 'strenght' 'strength'"},
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
     "scene.toml:8:7 UnknownName 'piano' [parts]"},
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
     "scene.toml:8:1 OutOfRange 'strength' 9 0 1"},
};
// clang-format on

}  // namespace

TEST_CASE("bad files: a scene that is wrong says where, what, and what to do", "[scene]") {
  const test::SceneFolder folder;
  for (const auto& file : kBadFiles) {
    INFO(file.what);
    folder.write("scene.toml", file.text);
    const auto built = build_scene(load_scene_leniently(folder.path() / "scene.toml"), standard_nodes());
    auto errors = folder.strip(test::summary(built));
    const auto name = folder.path().filename().string();
    if (const auto at = errors.find(name); at != std::string::npos) errors.replace(at, name.size(), "FOLDER");
    CHECK(errors == file.expected);
  }
}

TEST_CASE("hostile files: a scene is read as carefully as a graph", "[scene]") {
  const test::TemporaryFolder folder;
  const auto errors = [&](std::string_view text, std::uintmax_t bytes = 0) {
    const auto file = folder.write("scene.toml", text);
    if (bytes > 0) std::filesystem::resize_file(file, bytes);
    const auto built = build_scene(load_scene_leniently(file), standard_nodes());
    return folder.strip(test::summary(built));
  };
  CHECK(errors("format = 1\n", 1u << 30) == "scene.toml Syntax 16");
  CHECK(errors("format = 1\n\xff\xfe") == "scene.toml:2:1 Syntax");
  CHECK(errors("parts = " + std::string(100000, '[')) == "scene.toml:1:73 Syntax 64");
  CHECK(errors("duration = nan\n") == "scene.toml:1:12 OutOfRange");
}
