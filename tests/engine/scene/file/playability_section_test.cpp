#include <catch2/catch.hpp>

#include "engine/nodes/table.h"
#include "engine/scene/build_scene.h"
#include "tests/support/error_summary.h"
#include "tests/support/scene_folder.h"

using namespace tactus;

namespace {

struct Folder : test::SceneFolder {
  LoadedScene load(const std::string& section) const {
    const auto text =
        "format = 1\ndelay = \"1 ms\"\nduration = \"4 s\"\n[parts]\n"
        "instrument = { use = \"instrument.toml\", mic = \"plant.mic\", pedal = 0 }\n"
        "plant = { use = \"plant.toml\", drive = \"instrument.woofer\", lift = 0 }\n"
        "[playability]\n" +
        section;
    return parse_scene_leniently(text, (path() / "scene.toml").generic_string(), path());
  }
  std::string errors_of(const std::string& section) const {
    const auto built = build_scene(load(section), standard_nodes());
    return strip(test::summary(built));
  }
};

}  // namespace

TEST_CASE("playability section: what is left out has its usual value", "[scene]") {
  const Folder folder;
  const auto loaded = folder.load("kind = \"roll\"\ncontact = \"plant.stick\"\n");
  REQUIRE(loaded.scene);
  REQUIRE(loaded.scene->playability);
  const auto& playability = *loaded.scene->playability;
  CHECK(playability.kind == Playability::Kind::Roll);
  CHECK(playability.hits.name == "instrument.hit");
  CHECK(playability.contact.name == "plant.stick");
  CHECK(playability.fewest == 10);
  CHECK(playability.from_s == 1);
  CHECK_FALSE(playability.to_s);
  CHECK(folder.errors_of("kind = \"roll\"\ncontact = \"plant.stick\"\n") == "");
}

TEST_CASE("playability section: a tone has a pitch, a beginning and an end", "[scene]") {
  const Folder folder;
  const auto loaded = folder.load(
      "kind = \"tone\"\nsound = \"plant.mic\"\npitch = \"110 Hz\"\nbegin = \"50 ms\"\nto = \"3 s\"\nquiet = "
      "\"-40 dB\"\n");
  CHECK(loaded.errors.empty());
  REQUIRE(loaded.scene->playability);
  CHECK(loaded.scene->playability->pitch_hz == 110);
  CHECK(loaded.scene->playability->begin_s == Approx(0.05));
  CHECK(loaded.scene->playability->to_s == 3);
  CHECK(loaded.scene->playability->quiet == Approx(0.01));
}

TEST_CASE("playability section: the pitch may follow what a part gives out", "[scene]") {
  const Folder folder;
  folder.write("plant.toml", R"(format = 1
[inputs]
drive = { unit = "full scale" }
lift = { unit = "m" }
[outputs]
mic = { from = "drive" }
stick = { from = "lift", unit = "m" }
note = { from = "110 Hz", unit = "Hz" }
)");
  const std::string tone = "kind = \"tone\"\nsound = \"plant.mic\"\n";
  const auto loaded = folder.load(tone + "pitch = \"plant.note\"\n");
  REQUIRE(loaded.scene->playability);
  CHECK(loaded.scene->playability->pitch.name == "plant.note");
  CHECK(folder.errors_of(tone + "pitch = \"plant.note\"\n") == "");
  CHECK(folder.errors_of(tone + "pitch = \"plant.not\"\n") ==
        "scene.toml:10:9 UnknownName 'plant.not' 'plant.note'");
  CHECK(folder.errors_of(tone + "pitch = \"plant.stick\"\n") ==
        "scene.toml:10:9 UnitMismatch 'plant.stick' 'pitch'");
  CHECK(folder.errors_of(tone + "pitch = \"plant.mic\"\n") ==
        "scene.toml:10:9 UnitMismatch 'plant.mic' 'pitch'");
}

TEST_CASE("playability section: its errors come with line and column", "[scene]") {
  const Folder folder;
  CHECK(folder.errors_of("from = \"1 s\"\n") ==
        "scene.toml:7:1 Missing [playability] 'kind' 'kind' 'roll' 'tone'");
  CHECK(folder.errors_of("kind = \"rol\"\n") == "scene.toml:8:8 UnknownName 'kind' 'rol' 'roll'");
  CHECK(folder.errors_of("kind = \"roll\"\ncontact = \"plant.stick\"\npitch = \"110 Hz\"\n") ==
        "scene.toml:10:1 UnknownName 'pitch' 'kind' 'from' 'to' 'hits' 'contact' 'fewest' 'roll' 'rate' "
        "'about'");
  CHECK(folder.errors_of("kind = \"roll\"\n") ==
        R"(scene.toml:7:1 Missing '[playability]' 'contact' [roles] contact "plant.contact")");
  CHECK(folder.errors_of("kind = \"roll\"\ncontact = \"plant.stik\"\n") ==
        "scene.toml:9:11 UnknownName '[playability]' 'plant.stik' 'plant.stick'");
  CHECK(folder.errors_of("kind = \"tone\"\nsound = \"plant.mic\"\n") ==
        R"(scene.toml:7:1 Missing 'pitch' pitch "110 Hz" "wanted.pitch")");
  CHECK(folder.errors_of("kind = \"tone\"\nsound = \"plant.mic\"\npitch = \"1 s\"\n") ==
        R"(scene.toml:10:9 UnitMismatch '1 s' 'pitch' "440 Hz")");
  CHECK(folder.errors_of("kind = \"roll\"\ncontact = \"plant.stick\"\nfrom = \"3.5 s\"\n") ==
        "scene.toml:10:8 OutOfRange 'from' 'to' 'duration'");
  CHECK(folder.errors_of("kind = \"tone\"\nsound = \"plant.mic\"\npitch = \"110 Hz\"\nbegin = \"2 s\"\n") ==
        "scene.toml:11:9 OutOfRange 'begin' 'from' 'from' 1");
}
