#if defined(TACTUS_PROGRAM) && defined(__unix__)

#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/temporary_folder.h"

using namespace tactus;

namespace {

/// A scene whose plant and instrument have a network each.
struct Networks : test::TemporaryFolder {
  Networks() {
    write("plant.toml", R"(format = 1
[networks.drum]
solver = "exact"
oversample = 2
frame = { type = "ground" }
tip = { type = "mass", mass = "10 g", at = "1 mm" }
hold = { type = "spring", between = ["frame", "tip"], stiffness = "40 kN/m" }
[outputs]
tip = { from = "drum.tip.position", unit = "m" }
mic = { from = "drum.tip.position / 1 m" }
)");
    write("instrument.toml", R"(format = 1
name = "two"
[inputs]
mic = {}
[networks.model]
solver = "auto"
frame = { type = "ground" }
m = { type = "mass", mass = "10 g" }
k = { type = "spring", between = ["frame", "m"], stiffness = "40 kN/m" }
push = { type = "force", on = "m", force = "mic * 1 N" }
[outputs]
out = { from = "model.m.position / 1 m" }
)");
    write("scene.toml", R"(format = 1
name = "networks"
duration = "100 ms"
[parts]
instrument = { use = "instrument.toml", mic = "plant.mic" }
plant = { use = "plant.toml" }
)");
  }

  std::string run(const std::string& arguments, int highest_exit = 0) const {
    const auto out = path() / "out.txt";
    const auto command = "cd " + path().string() + " && " + TACTUS_PROGRAM + " " + arguments + " >" +
                         out.string() + " 2>/dev/null";
    CHECK(WEXITSTATUS(std::system(command.c_str())) <= highest_exit);
    std::ifstream text{out};
    return {std::istreambuf_iterator<char>{text}, {}};
  }
};

}  // namespace

TEST_CASE("networks: play, render and explain report each of them in one line and as JSON", "[apps]") {
  const Networks folder;
  const std::string drum = "network 'plant.drum' in plant.toml: exact x2, no error beyond rounding, ";
  const std::string model = "network 'model' in instrument.toml: explicit, error at most 0.0072 %, ";
  for (const std::string command : {"play scene.toml", "render scene.toml", "explain scene.toml"}) {
    CAPTURE(command);
    const auto text = folder.run(command);
    CHECK(text.find(drum) != std::string::npos);
    CHECK(text.find(model) != std::string::npos);
    const auto json = nlohmann::json::parse(folder.run(command + " --json"));
    std::vector<nlohmann::json> networks;
    for (const auto& part : json.contains("graphs") ? json["graphs"] : nlohmann::json::array({json}))
      networks.insert(networks.end(), part["network_solvers"].begin(), part["network_solvers"].end());
    REQUIRE(networks.size() == 2);
    for (const auto& network : networks) {
      CHECK(network["ns_per_frame"].get<double>() > 0);
      const bool exact = network["network"] == "plant.drum";
      CHECK(network["solver"] == (exact ? "exact" : "explicit"));
      CHECK(network["oversample"] == (exact ? 2 : 1));
      CHECK(network["error_bound"].get<double>() <= 1e-4);
    }
  }
  const auto text = folder.run("render instrument.toml --duration '100 ms'");
  CHECK(text.find(model) != std::string::npos);
}

TEST_CASE("networks: the error of a scene without [accuracy] stands beside its bound", "[apps]") {
  const auto text = Networks{}.run("render scene.toml --error");
  INFO(text);
  CHECK(text.find("network 'plant.drum' in plant.toml: exact x2, no error beyond rounding, ") !=
        std::string::npos);
  CHECK(text.find("tip: position of plant.tip") != std::string::npos);
  CHECK(text.find("bound") != std::string::npos);
}

TEST_CASE("networks: play and render of a scene say which of them produced what is not finite", "[apps]") {
  const Networks folder;
  for (const std::string command : {"play scene.toml", "render scene.toml"})
    CHECK(folder.run(command).find("  faults              none\n") != std::string::npos);
  // (w k)^2 = 4340, more than 4: with `explicit` it grows a thousandfold in each step. `play` ends with 1
  // where something failed.
  folder.write("stiff.toml", R"(format = 1
[networks.drum]
solver = "explicit"
frame = { type = "ground" }
tip = { type = "mass", mass = "1 mg", at = "1 mm" }
hold = { type = "spring", between = ["frame", "tip"], stiffness = "1e7 N/m" }
[outputs]
tip = { from = "drum.tip.position", unit = "m" }
mic = { from = "drum.tip.position / 1 m" }
)");
  folder.write("fails.toml",
               "format = 1\nname = \"fails\"\nduration = \"100 ms\"\n[parts]\n"
               "instrument = { use = \"instrument.toml\", mic = \"plant.mic\" }\n"
               "plant = { use = \"stiff.toml\" }\n");
  for (const std::string command : {"play fails.toml", "render fails.toml"}) {
    CAPTURE(command);
    CHECK(folder.run(command, 1).find("plant.drum produced non-finite values ") != std::string::npos);
    CHECK(nlohmann::json::parse(folder.run(command + " --json", 1))["faults"].size() == 1);
  }
}

#endif
