#include "engine/scene/file/scene_spec.h"

#include <catch2/catch.hpp>

#include "tests/support/messages.h"
#include "tests/support/scene_folder.h"

using namespace tactus;
using test::TemporaryFolder;

namespace {

constexpr auto kGraph = "format = 1\n";
constexpr auto kParts =
    "[parts]\ninstrument = { use = \"instrument.toml\" }\nplant = { use = \"plant.toml\" }\n";

struct Folder : TemporaryFolder {
  Folder() {
    write("instrument.toml", kGraph);
    write("plant.toml", kGraph);
  }
  Checked<SceneSpec> read(std::string_view text) const {
    return test::parse_scene(text, (path() / "scene.toml").string());
  }
  test::Messages mistakes(std::string_view text) const {
    const auto scene = read(text);
    return scene ? "" : strip(to_string(scene.error()));
  }
};

}  // namespace

TEST_CASE("scene: the bow of the manual becomes plain data", "[scene]") {
  const Folder folder;
  folder.write("scene.toml", R"(format = 1
name = "bow"
rate = "44.1 kHz"
delay = "20 ms"
duration = "6 s"
seed = 9007199254740991
[parts]
instrument = { use = "instrument.toml", piezo = "plant.piezo", ribbon = "finger" }
plant      = { use = "plant.toml", drive = "0.5 * instrument.shaker", bow_speed = "stroke", gain = 2 }
[gestures]
stroke = { points = [["0 s", 0], ["0.1 s", "100 mm/s"], ["3 s", "-0.1 m/s"]] }
finger = { points = [["0 s", "120 mm"], [2, "18 cm"]], curve = "step" }
knob   = { points = [[0, 1]], curve = "smooth" }
[converters]
bits = 16
[expect]
pitch = { measure = "frequency", of = "plant.piezo", from = "1 s", to = "6 s", min = "439 Hz", max = "441 Hz" }
calm  = { measure = "peak", max = 1 }
)");
  const auto scene = load_scene(folder.path());  // for a folder, its scene.toml
  REQUIRE(scene);
  CHECK(scene->name == "bow");
  CHECK(scene->rate == Hertz{44100});
  CHECK(scene->delay == Seconds{0.02});
  CHECK(scene->duration == 6_s);
  CHECK(scene->seed == 9007199254740991u);
  CHECK(scene->converters.on);
  CHECK(scene->converters.bits == 16);

  REQUIRE(scene->part("plant") != nullptr);
  const auto& plant = *scene->part("plant");
  CHECK(folder.strip(plant.graph->file.text()) == "plant.toml");
  REQUIRE(plant.wires.size() == 3);
  CHECK(plant.wires[0].key == "drive");
  CHECK(*plant.wires[0].value.text() == "0.5 * instrument.shaker");
  CHECK(scene->part("hand") == nullptr);

  const auto& stroke = *scene->gesture("stroke");
  CHECK(stroke.curve == Gesture::Curve::Linear);
  CHECK(stroke.unit.dimension == parse_unit("m/s")->dimension);
  CHECK_FALSE(stroke.bare);
  CHECK(stroke.points[1].time_s == 0.1);
  CHECK(stroke.points[1].value == Approx(0.1));
  const auto& finger = *scene->gesture("finger");
  CHECK(finger.curve == Gesture::Curve::Step);
  CHECK(finger.points[1].time_s == 2.0);
  CHECK(finger.points[1].value == Approx(0.18));
  CHECK(scene->gesture("knob")->bare);
  CHECK(scene->gesture("knob")->curve == Gesture::Curve::Smooth);

  REQUIRE(scene->expect.size() == 2);
  CHECK(scene->expect[0].measure == "frequency");
  CHECK(scene->expect[0].of == "plant.piezo");
  CHECK(*scene->expect[0].from_s == 1.0);
  CHECK(scene->expect[0].min->si == 439.0);
  CHECK_FALSE(scene->expect[1].min);
  CHECK(scene->expect[1].max->bare);
}

TEST_CASE("scene: what may be left out has the value that the manual says", "[scene]") {
  const Folder folder;
  const auto scene = folder.read(std::string{"format = 1\nduration = \"1 s\"\n"} + kParts);
  REQUIRE(scene);
  CHECK(scene->rate == 48_kHz);
  CHECK(scene->delay == 0_s);
  CHECK(scene->converters.on);
  CHECK(scene->converters.bits == 24);
  CHECK_FALSE(scene->seed);
  const auto off =
      folder.read(std::string{"format = 1\nduration = \"1 s\"\nconverters.off = true\n"} + kParts);
  REQUIRE(off);
  CHECK_FALSE(off->converters.on);
}

TEST_CASE("scene: all mistakes come in one go, those of its parts too", "[scene]") {
  const Folder folder;
  folder.write("plant.toml", "format = 1\nnods = 1\n");
  CHECK(folder.mistakes(R"(rate = 48
delay = "12 mm"
sead = 3
seed = 1.5
duration = -1
[parts]
instrument = { use = "instrment.toml", piezo = "plant.piezo +", list = [1, "2 *"] }
plant = { use = "plant.toml" }
hand = { mass = 3 }
[gestures]
hand = { points = [["0 s", 0]] }
a = { points = [["0 s", "1 m"], ["0 s", "1 N"], ["1 mm", 2], [3]], curve = "stpe" }
b = { }
[converters]
bits = 64
off = 1
[nodes]
[expect]
p = { of = "plant.piezo", from = "2 s", to = "1 s", min = 2, max = 1 }
q = { measure = "peak", min = "1 m", max = "2 s" }
r = { measure = "peak", mx = 3 }
)") ==
        R"(scene.toml:1:1: 'format' is missing; begin the file with format = 1
scene.toml:1:8: 'rate' cannot be 48 Hz; it runs from 1 kHz to 768 kHz
scene.toml:2:9: '12 mm' is in m, but 'delay' is in s; give "15 ms"
scene.toml:3:1: unknown key 'sead'; did you mean 'seed'?
scene.toml:4:8: 'seed' must be a whole number; give one from 0 to 9007199254740991
scene.toml:5:12: 'duration' cannot be -1 s; it runs from 1 ms to 86400 s
scene.toml:7:22: there is no file 'instrment.toml'; did you mean 'instrument.toml'?
scene.toml:7:62: the expression is incomplete; write a number, a name or '(' here
scene.toml:7:80: the expression is incomplete; write a number, a name or '(' here
scene.toml:9:1: part 'hand' has no 'use'; give its file, as in use = "hand.toml"
scene.toml:11:1: 'hand' cannot name a gesture: it names a part in line 9; choose another name
scene.toml:12:34: 0 s is not later than 0 s before it; the times of a gesture must be ascending
scene.toml:12:41: '1 N' is in N, but 'a' is in m; give "12 mm"
scene.toml:12:50: '1 mm' is in m, but 'time' is in s; give "15 ms"
scene.toml:12:62: a point must be a time and a value; write for instance ["0.1 s", "2 m/s"]
scene.toml:12:76: 'curve' cannot be 'stpe'; did you mean 'step'?
scene.toml:13:1: gesture 'b' lacks 'points'; give 'points': [[time, value], …] with ascending times
scene.toml:15:8: 'bits' cannot be 64; give one from 1 to 32
scene.toml:16:7: 'off' must be true or false, not a number; write off = true
scene.toml:17:2: 'nodes' is a key of graphs, but this is a scene; move it to the file of a part
scene.toml:19:1: expectation 'p' lacks 'measure'; give 'measure': what is measured
scene.toml:19:46: 'to' is not later than 'from'; swap them
scene.toml:19:68: 'max' is below 'min'; swap them
scene.toml:20:44: 'min' and 'max' are in different units; give both in the same unit
scene.toml:21:1: expectation 'r' lacks 'min' and 'max'; give at least one of them
scene.toml:21:25: unknown key 'mx'; did you mean 'max'?
plant.toml:2:1: unknown key 'nods'; did you mean 'nodes'?)");
}

TEST_CASE("scene: a plant is required, and so is a duration", "[scene]") {
  const Folder folder;
  CHECK(folder.mistakes("format = 1\n") ==
        "scene.toml:1:1: 'duration' is missing; give the length of the scene, as in duration = \"6 s\"\n"
        "scene.toml:1:1: the part 'plant' is missing; under [parts], write plant = { use = \"plant.toml\", … "
        "}");
}

TEST_CASE("scene: nothing is measured after its end", "[scene]") {
  const Folder folder;
  CHECK(folder.mistakes(std::string{"format = 1\nduration = \"6 s\"\n"} + kParts +
                        "[expect]\na = { measure = \"peak\", from = \"7 s\", max = 1 }\n") ==
        "scene.toml:7:32: 'from' cannot be 7 s; it runs from 0 s to 6 s");
}

TEST_CASE("scene: parts stay below the root, and mistakes that two parts share are told once", "[scene]") {
  const Folder folder;
  folder.write("shared/bad.toml", "nods = 1");
  const auto part = "format = 1\n[nodes]\nx = { use = \"../shared/bad.toml\" }\n";
  folder.write("drum/instrument.toml", part);
  folder.write("drum/plant.toml", part);
  folder.write("drum/scene.toml", std::string{"format = 1\nduration = 1\n"} + kParts);
  const auto narrow = load_scene(folder.path() / "drum");
  REQUIRE_FALSE(narrow);
  CHECK(folder.strip(to_string(narrow.error())) ==
        "drum/instrument.toml:3:13: '../shared/bad.toml' is outside the folder 'drum'; keep the files of an "
        "instrument inside it\n"
        "drum/plant.toml:3:13: '../shared/bad.toml' is outside the folder 'drum'; keep the files of an "
        "instrument "
        "inside it");
  const auto wide = load_scene(folder.path() / "drum", folder.path());
  REQUIRE_FALSE(wide);
  CHECK(folder.strip(to_string(wide.error())) ==
        "shared/bad.toml:1:1: 'format' is missing; begin the file with format = 1\n"
        "shared/bad.toml:1:1: unknown key 'nods'; did you mean 'nodes'?");
}

TEST_CASE("scene: a folder without a scene says which file it lacks", "[scene]") {
  const TemporaryFolder folder;
  const auto scene = load_scene(folder.path());
  REQUIRE_FALSE(scene);
  CHECK(folder.strip(to_string(scene.error())) == "scene.toml: there is no such file; check the path");
}

TEST_CASE("scene: without a name it is called as its file, or as the folder that it is the scene of",
          "[scene]") {
  const Folder folder;
  const auto text = std::string("format = 1\nduration = \"1 s\"\n") + kParts;
  CHECK(folder.read(text).value().name == folder.path().filename().string());
  CHECK(test::parse_scene(text, (folder.path() / "loud.toml").string()).value().name == "loud");
  CHECK(folder.read("name = \"wall\"\n" + text).value().name == "wall");
}
