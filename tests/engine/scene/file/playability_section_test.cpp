#include <catch2/catch.hpp>

#include "engine/nodes/table.h"
#include "engine/scene/build_scene.h"
#include "tests/support/messages.h"
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
    return parse_scene_leniently(text, (path() / "scene.toml").string(), path());
  }
  test::Messages mistakes(const std::string& section) const {
    const auto built = build_scene(load(section), standard_nodes());
    return built ? "" : strip(to_string(built.error()));
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
  CHECK(folder.mistakes("kind = \"roll\"\ncontact = \"plant.stick\"\n") == "");
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
  CHECK(folder.mistakes(tone + "pitch = \"plant.note\"\n") == "");
  CHECK(folder.mistakes(tone + "pitch = \"plant.not\"\n") ==
        "scene.toml:10:9: no signal 'plant.not' is recorded; did you mean 'plant.note'?");
  CHECK(folder.mistakes(tone + "pitch = \"plant.stick\"\n") ==
        "scene.toml:10:9: 'plant.stick' is in m, but 'pitch' is in Hz; give an output in Hz, or give it a "
        "unit in "
        "its part");
  CHECK(folder.mistakes(tone + "pitch = \"plant.mic\"\n")
            .starts_with("scene.toml:10:9: 'plant.mic' is a plain number, but 'pitch' is in Hz"));
}

TEST_CASE("playability section: its mistakes come with line and column", "[scene]") {
  const Folder folder;
  CHECK(folder.mistakes("from = \"1 s\"\n") ==
        "scene.toml:7:1: [playability] lacks 'kind'; give 'kind': kind of playing, one of 'roll' and 'tone'");
  CHECK(folder.mistakes("kind = \"rol\"\n") ==
        "scene.toml:8:8: 'kind' cannot be 'rol'; did you mean 'roll'?");
  CHECK(folder.mistakes("kind = \"roll\"\ncontact = \"plant.stick\"\npitch = \"110 Hz\"\n")
            .starts_with("scene.toml:10:1: unknown key 'pitch'"));
  CHECK(folder.mistakes("kind = \"roll\"\n")
            .starts_with("scene.toml:7:1: '[playability]' needs a signal with the role 'contact'"));
  CHECK(folder.mistakes("kind = \"roll\"\ncontact = \"plant.stik\"\n") ==
        "scene.toml:9:11: '[playability]' needs 'plant.stik', but no such signal is recorded; did you mean "
        "'plant.stick'?");
  CHECK(folder.mistakes("kind = \"tone\"\nsound = \"plant.mic\"\n") ==
        "scene.toml:7:1: a tone needs the expected 'pitch'; write pitch = \"110 Hz\", or an output of a "
        "part: \"wanted.pitch\"");
  CHECK(folder.mistakes("kind = \"tone\"\nsound = \"plant.mic\"\npitch = \"1 s\"\n")
            .starts_with("scene.toml:10:9: '1 s' is in s, but 'pitch' is in Hz"));
  CHECK(folder.mistakes("kind = \"roll\"\ncontact = \"plant.stick\"\nfrom = \"3.5 s\"\n") ==
        "scene.toml:10:8: the evaluated window is shorter than one second; lower 'from', or raise 'to' or "
        "'duration'");
  CHECK(folder.mistakes("kind = \"tone\"\nsound = \"plant.mic\"\npitch = \"110 Hz\"\nbegin = \"2 s\"\n")
            .starts_with("scene.toml:11:9: 'begin' is later than 'from'"));
}
