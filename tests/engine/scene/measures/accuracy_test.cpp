#include <catch2/catch.hpp>

#include "engine/nodes/table.h"
#include "engine/scene/build_scene.h"
#include "tests/support/error_summary.h"
#include "tests/support/scene_folder.h"

using namespace tactus;
using namespace tactus::test;

namespace {

/// All that is wrong with a scene of this [accuracy].
std::string errors_of(const std::string& lines) {
  const SceneFolder folder;
  folder.write("scene.toml",
               "format = 1\nduration = \"1 s\"\n[parts]\n"
               "plant = { use = \"plant.toml\", drive = 0, lift = \"1 mm\" }\n[accuracy]\n" +
                   lines);
  const auto compiled = compile_scene(load_scene_leniently(folder.path()), standard_nodes());
  return folder.strip(test::summary(compiled));
}

}  // namespace

TEST_CASE("accuracy: a scene of a plant alone says what must come out right", "[scene]") {
  CHECK(errors_of("a = { measure = \"position\", of = \"plant.stick\", to = \"0.5 s\", scale = \"1 mm\" }\n"
                  "b = { measure = \"frequency\", of = \"plant.stick\", exact = \"110 Hz\" }\n") == "");
}

TEST_CASE("accuracy: errors have their place", "[scene]") {
  CHECK(errors_of("a = { of = \"plant.stick\" }\n") == "scene.toml:6:1 Missing 'a' 'measure' 'measure'");
  CHECK(errors_of("a = { measure = \"positon\", of = \"plant.stick\" }\n") ==
        "scene.toml:6:17 UnknownName 'measure' 'positon' 'position'");
  CHECK(errors_of("a = { measure = \"position\" }\n") ==
        R"(scene.toml:6:1 Missing 'a' 'of' 'of' "plant.tip")");
  CHECK(errors_of("a = { measure = \"position\", of = \"plant.stik\" }\n") ==
        "scene.toml:6:34 UnknownName 'plant.stik' 'plant.stick'");
  CHECK(errors_of("a = { measure = \"position\", of = \"plant.stick\", exact = 1 }\n") ==
        "scene.toml:6:57 BadArgument 'position' 'exact'");
  CHECK(errors_of("a = { measure = \"frequency\", of = \"plant.stick\", exact = \"1 m\" }\n") ==
        "scene.toml:6:1 UnitMismatch 'frequency' 1");
  CHECK(errors_of("a = { measure = \"position\", of = \"plant.stick\", scale = 0 }\n") ==
        "scene.toml:6:57 OutOfRange 'scale' 0 1");
}
