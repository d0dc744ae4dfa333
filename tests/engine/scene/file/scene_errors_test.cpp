#include <catch2/catch.hpp>

#include "engine/nodes/table.h"
#include "engine/scene/build_scene.h"
#include "tests/support/error_summary.h"
#include "tests/support/scene_folder.h"

using namespace tactus;

namespace {

struct Folder : test::SceneFolder {
  std::string errors_of(const std::string& text) const {
    const auto file = (path() / "scene.toml").generic_string();
    const auto built = build_scene(parse_scene_leniently(text, file, path()), standard_nodes());
    return strip(test::summary(built));
  }
};

}  // namespace

TEST_CASE("scene: a scene without errors builds, and bare gestures fit any unit", "[scene]") {
  const Folder folder;
  CHECK(folder.errors_of(R"(format = 1
delay = "1 ms"
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0, strength = "fade" }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = "hand" }
[gestures]
hand = { points = [["0 s", 0], ["1 s", 0.2]] }
fade = { points = [["0 s", 0], ["1 s", 1]] }
[expect]
calm = { measure = "peak", of = "plant.stick", max = "1 m" }
detected = { measure = "count", of = "instrument.hit", max = 3 }
)") == "");
}

TEST_CASE("scene: the errors of text, wires, gestures and measures come together", "[scene]") {
  const Folder folder;
  CHECK(folder.errors_of(R"(format = 1
duration = "1 m"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mik", strenght = 1, strength = "hand" }
plant = { use = "plant.toml", drive = "hand", lift = "heigth" }
[gestures]
hand = { points = [["0 s", "10 mm"], ["1 s", "20 mm"]] }
height = { points = [["0 s", "0 m"]] }
[expect]
calm = { measure = "peek", of = "plant.stick", max = "1 m" }
detected = { measure = "count", of = "instrument.hti", max = 3 }
missed = { measure = "missed", max = 0 }
loud = { measure = "rms", min = 0 }
rate = { measure = "rate", of = "instrument.hit", min = "15 ms" }
[compare]
name = "softer"
strengt = 0
drum.gain = 1
)") ==
        R"(scene.toml:2:12 UnitMismatch '1 m' 'duration' "15 ms"
scene.toml:4:1 Missing 'pedal' pedal "plant.pedal"
scene.toml:4:48 UnknownName 'plant.mik' 'plant.mic'
scene.toml:4:60 UnknownName 'strenght' 'strength'
scene.toml:4:85 UnitMismatch 'strength' 'hand'
scene.toml:5:40 UnitMismatch 'drive'
scene.toml:5:55 UnknownName 'heigth' 'height'
scene.toml:10:20 UnknownName 'measure' 'peek' 'peak'
scene.toml:11:38 UnknownName 'instrument.hti' 'instrument.hit'
scene.toml:12:1 Missing 'missed' 'contact' [roles] contact "plant.contact"
scene.toml:13:1 Missing 'rms' 'of' of "plant.stick"
scene.toml:14:1 UnitMismatch 'rate' 15
scene.toml:17:1 UnknownName 'instrument' 'strengt' 'strength'
scene.toml:18:6 UnknownName 'drum' [parts])");
}

TEST_CASE("scene: controls take values and gestures within their range", "[scene]") {
  const Folder folder;
  CHECK(folder.errors_of(R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = 0, pedal = 0, strength = "rise" }
plant = { use = "plant.toml", drive = 0, lift = "1 s" }
[gestures]
rise = { points = [["0 s", 0], ["1 s", 2]] }
)") ==
        R"(scene.toml:4:72 OutOfRange 'strength' 2 'rise' 0 1
scene.toml:5:50 UnitMismatch 'lift')");
  CHECK(folder.errors_of(R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = 0, pedal = 0, strength = "plant.mic" }
plant = { use = "plant.toml", drive = 0, lift = "1 mm" }
)") == "scene.toml:4:72 WrongType 'plant.mic' 'strength'");
}

TEST_CASE("scene: a file that cannot be read hides what would be in it", "[scene]") {
  const Folder folder;
  folder.write("broken.toml", "format = 1\n[inputs\n");
  CHECK(folder.errors_of(R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "broken.toml", mic = "plant.mic + 1 m", anything = 1 }
plant = { use = "plant.toml", drive = "instrument.anything", lift = "1 s" }
[expect]
some = { measure = "count", of = "instrument.anything", max = 3 }
)") ==
        R"(scene.toml:5:70 UnitMismatch 'lift'
broken.toml:2:8 Syntax ']' '\n')");
  CHECK(folder.errors_of(R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "tap", lift = "tap" }
[gesture]
tap = { points = [["0 s", "0 m"]] }
)") == "scene.toml:6:2 UnknownName 'gesture' 'gestures'");
}
