#include <catch2/catch.hpp>

#include "engine/nodes/table.h"
#include "engine/scene/build_scene.h"
#include "tests/support/messages.h"
#include "tests/support/scene_folder.h"

using namespace tactus;

namespace {

struct Folder : test::SceneFolder {
  test::Messages mistakes(const std::string& text) const {
    const auto file = (path() / "scene.toml").string();
    const auto built = build_scene(parse_scene_leniently(text, file, path()), standard_nodes());
    return built ? "" : strip(to_string(built.error()));
  }
};

}  // namespace

TEST_CASE("scene: a scene without mistakes builds, and bare gestures fit any unit", "[scene]") {
  const Folder folder;
  CHECK(folder.mistakes(R"(format = 1
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
heard = { measure = "count", of = "instrument.hit", max = 3 }
)") == "");
}

TEST_CASE("scene: the mistakes of text, wires, gestures and measures come together", "[scene]") {
  const Folder folder;
  CHECK(folder.mistakes(R"(format = 1
duration = "1 m"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mik", strenght = 1, strength = "hand" }
plant = { use = "plant.toml", drive = "hand", lift = "heigth" }
[gestures]
hand = { points = [["0 s", "10 mm"], ["1 s", "20 mm"]] }
height = { points = [["0 s", "0 m"]] }
[expect]
calm = { measure = "peek", of = "plant.stick", max = "1 m" }
heard = { measure = "count", of = "instrument.hti", max = 3 }
missed = { measure = "missed", max = 0 }
loud = { measure = "rms", min = 0 }
rate = { measure = "rate", of = "instrument.hit", min = "15 ms" }
[compare]
name = "softer"
strengt = 0
drum.gain = 1
)") ==
        R"(scene.toml:2:12: '1 m' is in m, but 'duration' is in s; give "15 ms"
scene.toml:4:1: input 'pedal' of the instrument is not connected; give its source, as in pedal = "plant.pedal"
scene.toml:4:48: there is no 'plant.mik'; did you mean 'plant.mic'?
scene.toml:4:60: the instrument has no input or control 'strenght'; did you mean 'strength'?
scene.toml:4:85: control 'strength' has the unit of 0.5, but gesture 'hand' has the unit of 10 mm; give the points of the gesture the unit of the control
scene.toml:5:40: 'drive' is a plain number, but this is in m; divide by a quantity in m
scene.toml:5:55: there is no 'heigth'; did you mean 'height'?
scene.toml:10:20: 'measure' cannot be 'peek'; did you mean 'peak'?
scene.toml:11:35: no signal 'instrument.hti' is recorded; did you mean 'instrument.hit'?
scene.toml:12:1: 'missed' needs a signal with the role 'contact'; give one under [roles], as in contact = "plant.contact"
scene.toml:13:1: 'rms' needs an 'of'; give a signal, as in of = "plant.stick"
scene.toml:14:1: 'rate' is in Hz, but it is compared with 15 ms; give it in Hz
scene.toml:17:1: part 'instrument' has no control 'strengt'; did you mean 'strength'?
scene.toml:18:6: there is no part 'drum'; see [parts])");
}

TEST_CASE("scene: controls take values and gestures within their range", "[scene]") {
  const Folder folder;
  CHECK(
      folder.mistakes(R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = 0, pedal = 0, strength = "rise" }
plant = { use = "plant.toml", drive = 0, lift = "1 s" }
[gestures]
rise = { points = [["0 s", 0], ["1 s", 2]] }
)") ==
      R"(scene.toml:4:72: control 'strength' cannot be set to 2 by gesture 'rise'; it runs from 0 to 1
scene.toml:5:50: 'lift' is in m, but this is in s; give a quantity in m)");
  CHECK(
      folder.mistakes(R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = 0, pedal = 0, strength = "plant.mic" }
plant = { use = "plant.toml", drive = 0, lift = "1 mm" }
)") ==
      R"(scene.toml:4:72: 'plant.mic' is neither a value for control 'strength' nor a gesture; give a number or a quantity, or the name of a gesture)");
}

TEST_CASE("scene: a file that cannot be read hides what would be in it", "[scene]") {
  const Folder folder;
  folder.write("broken.toml", "format = 1\n[inputs\n");
  CHECK(folder.mistakes(R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "broken.toml", mic = "plant.mic + 1 m", anything = 1 }
plant = { use = "plant.toml", drive = "instrument.anything", lift = "1 s" }
[expect]
some = { measure = "count", of = "instrument.anything", max = 3 }
)") ==
        R"(scene.toml:5:70: 'lift' is in m, but this is in s; give a quantity in m
broken.toml:2:8: in this table header: expected ']', saw '\n'; fix this to see further errors)");
  CHECK(folder.mistakes(R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0 }
plant = { use = "plant.toml", drive = "tap", lift = "tap" }
[gesture]
tap = { points = [["0 s", "0 m"]] }
)") == R"(scene.toml:6:2: unknown key 'gesture'; did you mean 'gestures'?)");
}
