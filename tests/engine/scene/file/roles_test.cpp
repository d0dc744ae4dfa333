#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "engine/nodes/table.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/scene/guard_report.h"
#include "tests/support/error_summary.h"
#include "tests/support/scene_folder.h"

using namespace tactus;

namespace {

struct Folder : test::SceneFolder {
  LoadedScene load(const std::string& sections) const {
    const auto text =
        "format = 1\nduration = \"1 s\"\ndelay = \"1 ms\"\n[parts]\n"
        "instrument = { use = \"instrument.toml\", mic = \"plant.mic\", pedal = 0 }\n"
        "plant = { use = \"plant.toml\", drive = \"instrument.woofer\", lift = 0 }\n" +
        sections;
    return parse_scene_leniently(text, (path() / "scene.toml").generic_string(), path());
  }
  std::string errors(const std::string& sections) const {
    const auto built = build_scene(load(sections), standard_nodes());
    return strip(test::summary(built));
  }
};

}  // namespace

TEST_CASE("roles: named ones come first, in order, and ports play the others by their name", "[scene]") {
  const Folder folder;
  const auto roles = folder.load("[roles]\ncontact = \"plant.stick\"\nball = \"plant.mic\"\n").scene->roles;
  REQUIRE(roles.size() == 4);
  CHECK(roles[0].name == "contact");
  CHECK(roles[1].name == "ball");
  CHECK(roles[0].written);
  CHECK(signal_of(roles, "contact") == "plant.stick");
  CHECK(signal_of(roles, "hit") == "instrument.hit");
  CHECK(signal_of(roles, "stick") == "plant.stick");
  CHECK_FALSE(roles[2].written);
  CHECK(signal_of(roles, "monitor").empty());
}

TEST_CASE("roles: a control has one by [roles], else by its name", "[scene]") {
  const Folder folder;
  const auto named = *folder.load("[roles]\ntable_frequency = \"instrument.strength\"\n").scene;
  REQUIRE(control_of(named, "table_frequency"));
  CHECK(control_of(named, "table_frequency")->name() == "strength");
  CHECK(control_of(named, "table_frequency")->constant() == 0.5);
  CHECK_FALSE(control_of(*folder.load("").scene, "table_frequency"));
  CHECK(std::ranges::none_of(named.roles, [](const Role& role) { return role.name == "table_frequency"; }));
  CHECK(folder.errors("[roles]\ntable_frequency = \"strength\"\n") == "");
  const auto unknown = folder.errors("[roles]\ntable_frequency = \"strenght\"\n");
  CHECK(unknown.starts_with("scene.toml:8:19 UnknownName"));
  CHECK(unknown.find("'strength'") != std::string::npos);
}

TEST_CASE("roles: unknown roles and signals are errors at their place", "[scene]") {
  const Folder folder;
  CHECK(folder.errors("[roles]\nstik = \"plant.stick\"\n").starts_with("scene.toml:8:1 UnknownName"));
  CHECK(folder.errors("[roles]\nstick = \"plant.stik\"\n").starts_with("scene.toml:8:9 "));
  CHECK(folder.errors("[roles]\nstick = 1\n").starts_with("scene.toml:8:9 "));
  CHECK(folder.errors("[expect]\nbounce = { measure = \"restitution\", max = 1 }\n").find("'contact'") !=
        std::string::npos);
  CHECK(folder.errors("[roles]\ncontact = \"plant.stick\"\n"
                      "[expect]\nbounce = { measure = \"restitution\", max = 1 }\n") == "");
}

TEST_CASE("roles: the monitor outputs are those with the role, else all of kind audio", "[scene]") {
  const auto plan = compile(parse_graph_leniently(R"(format = 1
[inputs]
mic = {}
[outputs]
woofer = { from = "mic" }
sound  = { from = "mic", kind = "audio" }
click  = { from = "2 * mic", kind = "audio" }
)",
                                                  "two.toml"),
                            standard_nodes(), {});
  REQUIRE(plan);
  using Names = std::vector<std::string>;
  const auto with = [&](const char* signal) { return sound_names(**plan, {{"monitor", signal, {}}}); };
  CHECK(with("instrument.click") == Names{"click"});
  CHECK(with("instrument.woofer") == Names{"sound", "click"});
  CHECK(with("plant.body") == Names{"sound"});
  CHECK(sound_names(**plan) == Names{"sound"});
}

TEST_CASE("roles: no port of a shipped file is named in generic code", "[scene]") {
  namespace fs = std::filesystem;
  const std::regex port{R"re((^|[^\\])"(plant|instrument)\.(?!toml)[a-z_]+")re"}, comment{R"(//.*)"};
  int files = 0;
  for (const auto* folder : {"engine/scene", "engine/rig", "engine/study", "engine/graph", "apps/play",
                             "apps/check", "apps/render", "apps/nodes"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path{TACTUS_SOURCE_DIR} / folder)) {
      if (entry.path().extension() != ".cpp" && entry.path().extension() != ".h") continue;
      ++files;
      std::ifstream file{entry.path()};
      for (std::string line; std::getline(file, line);) {
        INFO(entry.path() << ": " << line);
        CHECK_FALSE(std::regex_search(std::regex_replace(line, comment, ""), port));
      }
    }
  CHECK(files > 100);
}
