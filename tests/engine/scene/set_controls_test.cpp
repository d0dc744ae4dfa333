#include <catch2/catch.hpp>

#include "engine/nodes/table.h"
#include "engine/scene/build_scene.h"
#include "tests/support/scene_folder.h"

using namespace tactus;

TEST_CASE("scene: a gesture on a control that a network is made with is refused", "[scene]") {
  const test::SceneFolder folder;
  folder.write("bar.toml", R"(format = 1
[controls]
tension = { value = "100 N/m", range = ["1 N/m", "1 kN/m"] }
[inputs]
mic = { unit = "full scale" }
[networks.bar]
tip   = { type = "oscillator", mass = "1 g", stiffness = "tension" }
push  = { type = "force", on = "tip", force = "1 N * mic" }
[outputs]
woofer = { from = "bar.tip.position / 1 m" }
)");
  const auto compiled = [&](const char* points) {
    folder.write("scene.toml", std::string{R"(format = 1
duration = "1 s"
delay = "1 ms"
[parts]
instrument = { use = "bar.toml", mic = "plant.mic", tension = "tighter" }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = "0 mm" }
[gestures]
tighter = { points = )"} + points + " }\n");
    return compile_scene(load_scene_leniently(folder.path() / "scene.toml"), standard_nodes());
  };
  CHECK(compiled(R"([["0 s", "50 N/m"], ["1 s", "50 N/m"]])"));
  const auto moved = compiled(R"([["0 s", "50 N/m"], ["1 s", "60 N/m"]])");
  REQUIRE_FALSE(moved);
  REQUIRE(moved.error().size() == 1);
  CHECK(moved.error().front().code == Errc::WrongType);
  CHECK(moved.error().front().where.ends_with("scene.toml:5:63"));
}

TEST_CASE("scene: what is set by name wins over the gesture that would move it", "[scene]") {
  const test::SceneFolder folder;
  folder.write("scene.toml", R"(format = 1
duration = "1 s"
delay = "1 ms"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0, strength = "swell" }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = "0 mm" }
[gestures]
swell = { points = [["0 s", 0.1], ["1 s", 0.9]] }
)");
  const auto scene = load_scene_leniently(folder.path() / "scene.toml");
  const auto moved = compile_scene(scene, standard_nodes());
  REQUIRE(moved);
  CHECK_FALSE(moved->journal.empty());

  SceneOptions options;
  options.set["strength"] = ControlValue{0.25};
  const auto fixed = compile_scene(scene, standard_nodes(), options);
  REQUIRE(fixed);
  CHECK(fixed->journal.empty());
  REQUIRE(fixed->instrument->controls.size() == 1);
  CHECK(fixed->instrument->controls[0].control.value == 0.25);
}

TEST_CASE("scene: a gesture that nothing takes is named", "[scene]") {
  const test::SceneFolder folder;
  folder.write("scene.toml", R"(format = 1
duration = "1 s"
delay = "1 ms"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic", pedal = 0, strength = "swell" }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = "rises" }
[gestures]
swell  = { points = [["0 s", 0.1], ["1 s", 0.9]] }
rises  = { points = [["0 s", "0 mm"], ["1 s", "1 mm"]] }
wobble = { points = [["0 s", "0 mm"], ["1 s", "1 mm"]] }
)");
  const auto compiled = compile_scene(load_scene_leniently(folder.path() / "scene.toml"), standard_nodes());
  REQUIRE(compiled);
  REQUIRE(compiled->plant->warnings.size() == 1);
  const auto& warning = compiled->plant->warnings.front();
  CHECK(warning.where.ends_with("scene.toml:10:1"));
  CHECK(warning.what == "gesture 'wobble' is not used");
}
