#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <stdexcept>

#include "engine/nodes/networks/network.h"
#include "engine/runtime/player.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"

using namespace tactus;
using namespace tactus::test;

namespace {

// A tuning fork that is struck by an input.
const std::string kFork =
    "fork = { type = \"oscillator\", mass = \"20 g\", frequency = \"440 Hz\", damping_ratio = 0.001 }\n"
    "blow = { type = \"force\", on = \"fork\", force = \"1 N * x\" }\n";

std::string graph_of(const std::string& elements, const std::string& read = "n.fork.position / 1 mm",
                     const std::string& nodes = "") {
  return "format = 1\nname = \"n\"\n[inputs]\nx = {}\n[networks.n]\nsolver = \"passive\"\n" + elements +
         "[nodes]\n" + nodes + "[outputs]\nout = { from = \"" + read + "\" }\n";
}

const NetworkView& network_of(const Player& player) {
  for (const auto& node : player.plan().nodes)
    if (const auto* view = dynamic_cast<const NetworkView*>(node.get())) return *view;
  throw std::runtime_error("no network");
}

std::size_t parts_of(const Player& player) {
  std::size_t count = 0;
  for_each_list(network_of(player).recipe.elements,
                [&](PartKind, const auto& list) { count += list.size(); });
  return count;
}

std::set<std::string> left_out(const Player& player) {
  std::set<std::string> left;
  for (const auto& [path, reason] : player.plan().left_out) left.insert(path + ": " + reason);
  return left;
}
bool has_left_out(const Player& player, const std::string& path) {
  return std::ranges::any_of(player.plan().left_out, [&](const auto& left) { return left.path == path; });
}

Samples played(Player& player) { return run(player, {noise(4800, 3)}, 4800, {64})[0]; }

}  // namespace

TEST_CASE("leave out: what acts on nothing that is read, or never, costs a network nothing", "[physics]") {
  const auto alone = engine_of(graph_of(kFork));
  const auto expected = played(*alone);
  CHECK(left_out(*alone).empty());

  struct Case {
    std::string elements;
    std::set<std::string> left;
  };
  const Case cases[] = {
      {"chain = { type = \"chain\", masses = 200, mass = \"0.1 g\", stiffness = \"1 kN/m\" }\n",
       {"n.chain: reaches no output"}},
      {"floor = { type = \"ground\" }\n"
       "rub = { type = \"friction\", between = [\"floor\", \"fork\"], normal = \"0 N\", holding = 0.5 }\n",
       {"n.rub: its force is always 0"}},
      {"floor = { type = \"ground\" }\n"
       "rub = { type = \"friction\", between = [\"floor\", \"fork\"], normal = \"-1 N\" }\n",
       {"n.rub: its force is always 0"}},
      {"ball = { type = \"mass\", mass = \"1 g\", at = \"1 mm\" }\nfloor = { type = \"ground\" }\n"
       "touch = { type = \"contact\", between = [\"floor\", \"ball\"], stiffness = \"1e6 N/m^1.5\" }\n"
       "weight = { type = \"force\", on = \"ball\", force = \"-0.01 N\" }\n",
       {"n.ball: reaches no output", "n.touch: reaches no output", "n.weight: reaches no output"}},
      {"push = { type = \"force\", on = \"fork\", force = \"0 N\" }\n", {"n.push: its force is always 0"}},
      {"hand = { type = \"hand\", on = \"fork\", force = \"0 N\" }\n", {"n.hand: its force is always 0"}},
      {"coil = { type = \"coil\", on = \"fork\", voltage = \"1 V * x\", force_factor = \"0 T m\", resistance "
       "= \"6 ohm\" }\n",
       {"n.coil: its force is always 0"}},
      {"other = { type = \"mass\", mass = \"1 g\" }\n"
       "loose = { type = \"spring\", between = [\"other\", \"fork\"], stiffness = \"0 N/m\" }\n",
       {"n.other: reaches no output", "n.loose: its force is always 0"}},
      {"string = { type = \"mass\", mass = \"1 g\" }\n"
       "out = { type = \"port\", on = \"string\", impedance = \"1 N s/m\", wave = \"1 N * x\" }\n",
       {"n.string: reaches no output", "n.out: reaches no output"}},
  };
  for (const auto& [elements, left] : cases) {
    INFO(elements);
    const auto among = engine_of(graph_of(kFork + elements));
    CHECK(left_out(*among) == left);
    CHECK(parts_of(*among) == parts_of(*alone));
    CHECK(network_of(*among).recipe.signals == 1);
    CHECK(played(*among) == expected);
  }
}

TEST_CASE("leave out: a network's energy, and what is read, count all that they consist of", "[physics]") {
  const std::string chain =
      "chain = { type = \"chain\", masses = 20, mass = \"0.1 g\", stiffness = \"1 kN/m\", at = \"1 mm\" }\n"
      "loose = { type = \"spring\", between = [\"chain.3\", \"fork\"], stiffness = \"0 N/m\" }\n"
      "ear = { type = \"probe\", on = \"chain.20\" }\n";
  const auto energy = engine_of(graph_of(kFork + chain, "n.energy / 1 J"));
  CHECK(left_out(*energy).empty());
  // An extension that is read is there, and both of its ends.
  const auto extension = engine_of(graph_of(kFork + chain, "n.loose.extension / 1 mm"));
  CHECK(left_out(*extension).empty());
  CHECK(played(*extension)[0] == Approx(-1.0));
  // One mass of a chain needs all of it.
  const auto ear = engine_of(graph_of(kFork + chain, "n.ear.position / 1 mm"));
  const std::set<std::string> fork{"n.fork: reaches no output", "n.blow: reaches no output",
                                   "n.loose: its force is always 0", "x: reaches no output"};
  CHECK(left_out(*ear) == fork);
  CHECK(network_of(*ear).recipe.elements.points.size() == 21);
}

TEST_CASE("leave out: a friction needs what presses it, which does not need the friction", "[physics]") {
  const std::string pressed =
      "floor = { type = \"ground\" }\nshoe = { type = \"mass\", mass = \"5 g\" }\n"
      "press = { type = \"spring\", between = [\"floor\", \"shoe\"], stiffness = \"100 N/m\", rest = \"-1 "
      "mm\" }\n"
      "rub = { type = \"friction\", between = [\"floor\", \"fork\"], normal = \"press.force\" }\n";
  CHECK(left_out(*engine_of(graph_of(kFork + pressed))).empty());
  const auto shoe = engine_of(graph_of(kFork + pressed, "n.shoe.position / 1 mm"));
  CHECK(has_left_out(*shoe, "n.rub"));
  CHECK(has_left_out(*shoe, "n.fork"));
  CHECK_FALSE(has_left_out(*shoe, "n.press"));
}

TEST_CASE("leave out: nothing is computed for elements that have been left out", "[physics][graph]") {
  const std::string chain =
      "chain = { type = \"chain\", masses = 200, mass = \"0.1 g\", stiffness = \"1 kN/m\" }\n"
      "pull = { type = \"force\", on = \"chain.7\", force = \"1 N * smooth\" }\n";
  const std::string smooth = "smooth = { type = \"low_pass\", in = \"x\", cutoff = \"100 Hz\" }\n";
  const auto engine = engine_of(graph_of(kFork + chain, "n.fork.position / 1 mm", smooth));
  CHECK(has_left_out(*engine, "smooth"));
  CHECK(engine->plan().nodes.size() == 1);
  // A port that is fed back on itself around an element that nobody reads is no loop any more.
  const std::string port =
      "body = { type = \"mass\", mass = \"1 g\" }\n"
      "out = { type = \"port\", on = \"body\", impedance = \"1 N s/m\", wave = \"-1 * n.out.wave\" }\n";
  const auto looped = engine_of(graph_of(kFork + port, "n.body.position / 1 mm"));
  const auto cut = engine_of(graph_of(kFork + port));
  const auto loops = [](const Player& player) {
    return std::ranges::count_if(player.plan().sections, [](const auto& section) { return section.loop; });
  };
  CHECK(loops(*looped) == 1);
  CHECK(loops(*cut) == 0);
}
