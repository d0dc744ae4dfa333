#include "engine/scene/file/scene_spec.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/graph/file/read_graph.h"
#include "tests/support/error_summary.h"
#include "tests/support/parse_graph.h"
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
    return test::parse_scene(text, (path() / "scene.toml").generic_string());
  }
  std::string errors_of(std::string_view text) const {
    const auto scene = read(text);
    return strip(test::summary(scene));
  }
};

}  // namespace

TEST_CASE("scene: a key of scenes in a graph file has an error of its own", "[scene]") {
  const auto error_with = [](const std::string& key) {
    const auto graph = test::parse_graph("format = 1\n" + key + " = 1\n", "test.toml");
    auto text = graph ? std::string{} : to_string(graph.error().front());
    if (const auto at = text.find(key); at != std::string::npos) text.replace(at, key.size(), "KEY");
    return text;
  };
  const auto keys = graph_fields().keys();
  for (const auto& key : scene_fields().keys()) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    CHECK(error_with(key) == error_with("duration"));
  }
  CHECK(error_with("unknown") != error_with("duration"));
}

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

TEST_CASE("scene: all errors come in one go, those of its parts too", "[scene]") {
  const Folder folder;
  folder.write("plant.toml", "format = 1\nnods = 1\n");
  CHECK(folder.errors_of(R"(rate = 48
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
        R"(scene.toml:1:1 Missing 'format' format 1
scene.toml:1:8 OutOfRange 'rate' 48 1 768
scene.toml:2:9 UnitMismatch '12 mm' 'delay' "15 ms"
scene.toml:3:1 UnknownName 'sead' 'seed'
scene.toml:4:8 OutOfRange 'seed' 0 9007199254740991
scene.toml:5:12 OutOfRange 'duration' -1 1 86400
scene.toml:7:22 BadFile 'instrment.toml' 'instrument.toml'
scene.toml:7:62 Syntax '('
scene.toml:7:80 Syntax '('
scene.toml:9:1 Missing 'hand' 'use' use "hand.toml"
scene.toml:11:1 Duplicate 'hand' 9
scene.toml:12:34 OutOfRange 0 0
scene.toml:12:41 UnitMismatch '1 N' 'a' "12 mm"
scene.toml:12:50 UnitMismatch '1 mm' 'time' "15 ms"
scene.toml:12:62 WrongType "0.1 s" "2 m/s"
scene.toml:12:76 UnknownName 'curve' 'stpe' 'step'
scene.toml:13:1 Missing 'b' 'points' 'points'
scene.toml:15:8 OutOfRange 'bits' 64 1 32
scene.toml:16:7 WrongType 'off' off
scene.toml:17:2 UnknownName 'nodes'
scene.toml:19:1 Missing 'p' 'measure' 'measure'
scene.toml:19:46 OutOfRange 'to' 'from'
scene.toml:19:68 OutOfRange 'max' 'min'
scene.toml:20:44 UnitMismatch 'min' 'max'
scene.toml:21:1 Missing 'r' 'min' 'max'
scene.toml:21:25 UnknownName 'mx' 'max'
plant.toml:2:1 UnknownName 'nods' 'nodes')");
}

TEST_CASE("scene: an instrument or a plant is required, and so is a duration", "[scene]") {
  const Folder folder;
  CHECK(folder.errors_of("format = 1\n") ==
        R"(scene.toml:1:1 Missing 'duration' duration "6 s"
scene.toml:1:1 Missing [parts] instrument use "instrument.toml")");
  CHECK(folder.errors_of(
            "format = 1\nduration = \"1 s\"\n[parts]\ninstrument = { use = \"instrument.toml\", mic = 0, "
            "pedal = 0 }\n") == "");
}

TEST_CASE("scene: nothing is measured after its end", "[scene]") {
  const Folder folder;
  CHECK(folder.errors_of(std::string{"format = 1\nduration = \"6 s\"\n"} + kParts +
                         "[expect]\na = { measure = \"peak\", from = \"7 s\", max = 1 }\n") ==
        "scene.toml:7:32 OutOfRange 'from' 7 0 6");
}

TEST_CASE("scene: parts stay below the root, and errors that two parts share are reported once", "[scene]") {
  const Folder folder;
  folder.write("shared/bad.toml", "nods = 1");
  const auto part = "format = 1\n[nodes]\nx = { use = \"../shared/bad.toml\" }\n";
  folder.write("drum/instrument.toml", part);
  folder.write("drum/plant.toml", part);
  folder.write("drum/scene.toml", std::string{"format = 1\nduration = 1\n"} + kParts);
  const auto narrow = load_scene(folder.path() / "drum");
  REQUIRE_FALSE(narrow);
  CHECK(folder.strip(test::summary(narrow)) ==
        R"(drum/instrument.toml:3:13 OutOfRange '../shared/bad.toml' 'drum'
drum/plant.toml:3:13 OutOfRange '../shared/bad.toml' 'drum')");
  const auto wide = load_scene(folder.path() / "drum", folder.path());
  REQUIRE_FALSE(wide);
  CHECK(folder.strip(test::summary(wide)) ==
        R"(shared/bad.toml:1:1 Missing 'format' format 1
shared/bad.toml:1:1 UnknownName 'nods' 'nodes')");
}

TEST_CASE("scene: a folder without a scene says which file it lacks", "[scene]") {
  const TemporaryFolder folder;
  const auto scene = load_scene(folder.path());
  REQUIRE_FALSE(scene);
  CHECK(folder.strip(test::summary(scene)) == "scene.toml BadFile");
}

TEST_CASE("scene: without a name it is called as its file, or as the folder that it is the scene of",
          "[scene]") {
  const Folder folder;
  const auto text = std::string("format = 1\nduration = \"1 s\"\n") + kParts;
  CHECK(folder.read(text).value().name == folder.path().filename().string());
  CHECK(test::parse_scene(text, (folder.path() / "loud.toml").generic_string()).value().name == "loud");
  CHECK(folder.read("name = \"wall\"\n" + text).value().name == "wall");
}
