#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/graph/body_source.h"
#include "engine/runtime/player.h"
#include "tests/support/allocation_count.h"
#include "tests/support/graphs/graph_runner.h"

#if defined(TACTUS_HAS_ODE)

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kLinkGravity = 9.81, kLinkStep_s = 1e-3;

std::string link_graph(const std::string& elements, const std::vector<std::string>& read) {
  std::string text = "format = 1\nname = \"n\"\n[inputs]\nx = {}\n[worlds.w]\n" + elements + "[outputs]\n";
  for (std::size_t i = 0; i < read.size(); ++i)
    text += "out" + std::to_string(i) + " = { from = \"" + read[i] + "\" }\n";
  return text;
}

Channels link_run(Player& engine, int frames, const std::vector<int>& blocks = {64}) {
  return run(engine, {std::vector<double>(static_cast<std::size_t>(frames), 0.0)}, frames, blocks);
}

/// Control changes, all of one frame taking effect with the step that follows.
class LinkJournal {
 public:
  explicit LinkJournal(const Player& engine) : engine_(engine) {}
  void set(std::int64_t frame, const std::string& name, double value) {
    const int control = engine_.control_index(name);
    REQUIRE(control >= 0);
    entries.push_back({frame, JournalEntry::Kind::ControlChange, control, value});
  }
  void pull(std::int64_t frame, const std::string& name) {
    set(frame, name, 1);
    set(frame + 1, name, 0);
  }
  /// Sorted by frame.
  std::vector<JournalEntry> all() {
    std::stable_sort(entries.begin(), entries.end(),
                     [](const auto& a, const auto& b) { return a.frame < b.frame; });
    return entries;
  }
  std::vector<JournalEntry> entries;

 private:
  const Player& engine_;
};

const std::string kLinkFall = "gravity = { type = \"gravity\" }\n";
const std::string kLinkRod =
    "rod = { type = \"capsule\", radius = \"5 mm\", length = \"20 cm\", mass = \"0.1 kg\", x = \"3 cm\", "
    "vy = \"0.2 m/s\", turn = [0, 0.4, 0] }\n";
const std::vector<std::string> kLinkRead = {"w.rod.x / 1 m", "w.rod.z / 1 m", "w.rod.wy / 1 rad * 1 s"};

/// A rod that gets a link, loses it and gets another one.
const std::string kLinkPool =
    kLinkFall + kLinkRod +
    "base = { type = \"box\", width = \"4 cm\", depth = \"4 cm\", height = \"4 cm\", "
    "mass = \"1 kg\", x = \"20 cm\" }\n"
    "link = { type = \"link\", remote = \"yes\" }\n";

std::vector<JournalEntry> link_changes(const Player& engine) {
  LinkJournal journal{engine};
  const auto make = [&](std::int64_t frame, double kind, double second) {
    journal.set(frame, "w_link_kind", kind);
    journal.set(frame, "w_link_first", 1);
    journal.set(frame, "w_link_second", second);
    journal.set(frame, "w_link_ax", 0.2);
    journal.set(frame, "w_link_ay", 1);
    journal.set(frame, "w_link_az", 0);
    journal.pull(frame, "w_link_attach");
  };
  make(4800, 1, 0);
  journal.set(6000, "w_link_stiffness", 0.5);
  journal.set(6000, "w_link_damping", 0.01);
  make(9000, 0, 0);
  make(12001, 5, 2);
  return journal.all();
}

BodySource* bodies_of(const Player& engine) {
  for (const auto& node : engine.plan().nodes)
    if (auto* source = dynamic_cast<BodySource*>(node.get())) return source;
  return nullptr;
}

}  // namespace

TEST_CASE("world: no finite number ends the program", "[nodes]") {
  const auto number = GENERATE(1e12, 1e20, 1e38, 1e150, 1e300);
  const auto kind = GENERATE(1, 2, 3, 5);
  const auto name = GENERATE("x", "z", "ax", "az", "stiffness", "damping");
  CAPTURE(number, kind, name);
  const auto engine = engine_of(link_graph(kLinkPool, kLinkRead));
  LinkJournal journal{*engine};
  journal.set(480, "w_link_kind", kind);
  journal.set(480, "w_link_first", 1);
  journal.set(480, "w_link_ay", 1);
  journal.set(480, std::string{"w_link_"} + name, number);
  journal.pull(480, "w_link_attach");
  engine->set_journal(journal.all());
  for (const auto& channel : link_run(*engine, 9600))
    CHECK(std::ranges::all_of(channel, [](double x) { return std::isfinite(x); }));
}

TEST_CASE("world: a body that a force throws out of range is a fault, and the world begins anew", "[nodes]") {
  const auto engine = engine_of(
      "format = 1\nname = \"n\"\n[inputs]\nx = {}\n[controls]\npush = { value = \"0 N\", range = [\"0 N\", "
      "\"1e20 N\"], "
      "smooth = \"0 s\" }\n[worlds.w]\nball = { type = \"sphere\", radius = \"5 mm\", mass = \"0.1 kg\", x = "
      "\"3 cm\", "
      "fx = \"push\" }\n[outputs]\ny = { from = \"w.ball.x / 1 m\" }\n");
  LinkJournal journal{*engine};
  journal.set(480, "push", 1e20);  // 1e18 m/s after a step of 1 ms
  journal.set(4800, "push", 0);
  engine->set_journal(journal.all());
  const auto out = link_run(*engine, 9600);
  REQUIRE(engine->faults().size() == 1);
  CHECK(engine->faults()[0].count > 0);
  CHECK(std::abs(out[0][9599] - 0.03) < 1e-12);  // where the file puts it
}

TEST_CASE("world link: of each kind it moves as the joint of the file does", "[physics]") {
  const auto [joint, link] = GENERATE(table<std::string, std::string>(
      {{"type = \"hinge\", axis = [0, 1, 0], x = \"1 cm\", z = \"9 cm\"",
        "kind = 1, ax = 0, ay = 1, az = 0, x = \"1 cm\", z = \"9 cm\""},
       {"type = \"slider\", axis = [1, 0, 1]", "kind = 2, ax = 1, az = 1"},
       {"type = \"ball\", x = \"1 cm\", z = \"9 cm\"", "kind = 3, x = \"1 cm\", z = \"9 cm\""},
       {"type = \"fixed\"", "kind = 4"}}));
  const auto file =
      engine_of(link_graph(kLinkFall + kLinkRod + "j = { on = \"rod\", " + joint + " }\n", kLinkRead));
  const auto made = engine_of(
      link_graph(kLinkFall + kLinkRod + "j = { type = \"link\", first = 1, " + link + " }\n", kLinkRead));
  INFO(link);
  CHECK((link_run(*made, 24000) == link_run(*file, 24000)));
}

TEST_CASE("world link: kinds with two axes leave those free and no other", "[physics]") {
  // Both axes of the universal joint are horizontal: the rod swings as a pendulum and does not twist. The
  // piston is vertical: it falls freely.
  const auto z = [](const std::string& link, const char* read) {
    const auto engine = engine_of(link_graph(
        kLinkFall +
            "block = { type = \"box\", width = \"4 cm\", depth = \"2 cm\", height = \"2 cm\", mass = 1, "
            "x = \"10 cm\" }\nj = { type = \"link\", first = 1, " +
            link + " }\n",
        {read}));
    return link_run(*engine, 961)[0].back();
  };
  const double fall = -kLinkGravity * kLinkStep_s * kLinkStep_s * 20 * 21 / 2;
  CHECK(z("kind = 7", "w.block.z / 1 m") == Approx(fall).epsilon(1e-9));
  CHECK(z("kind = 7, ax = 1, az = 0", "w.block.z / 1 m") == Approx(0.0).margin(1e-6));
  // The centre turns about the origin with m g l / (I + m l^2): the block starts with that acceleration.
  const double l = 0.1, inertia = (0.04 * 0.04 + 0.02 * 0.02) / 12 + l * l;
  CHECK(z("kind = 5, ax = 1, az = 0", "w.block.z / 1 m") == Approx(fall * l * l / inertia).epsilon(0.02));
  CHECK(z("kind = 5, ax = 1, az = 0, by = 0, bz = 1", "w.block.z / 1 m") == Approx(0.0).margin(1e-6));
}

TEST_CASE("world link: a spring balances a weight and an effort at their theoretical places", "[physics]") {
  const auto settled = [](const std::string& more) {
    const auto engine = engine_of(link_graph(
        kLinkFall +
            "block = { type = \"box\", width = \"4 cm\", depth = \"4 cm\", height = \"4 cm\", mass = "
            "\"0.2 kg\" }\nj = { type = \"link\", kind = 2, first = 1, stiffness = 400, damping = 12" +
            more + " }\n",
        {"w.block.z / 1 m"}));
    return link_run(*engine, 96000)[0].back();
  };
  CHECK(settled("") == Approx(-0.2 * kLinkGravity / 400).epsilon(1e-6));
  CHECK(settled(", effort = 1") == Approx((1 - 0.2 * kLinkGravity) / 400).epsilon(1e-6));
}

TEST_CASE("world link: it is made and removed at its frame whatever the block size and after a reset",
          "[physics]") {
  const auto engine = engine_of(link_graph(kLinkPool, kLinkRead));
  engine->set_journal(link_changes(*engine));
  const int frames = 24000;
  const auto expected = link_run(*engine, frames);
  CHECK((link_run(*engine, frames) == expected));
  for (const auto& blocks : {std::vector{1}, std::vector{1000}, std::vector{7, 48, 300}})
    CHECK((link_run(*engine, frames, blocks) == expected));
  // Until the first change the rod falls freely.
  CHECK(expected[1][4800] == Approx(-kLinkGravity * kLinkStep_s * kLinkStep_s * 99 * 100 / 2).epsilon(0.03));
  CHECK(expected[1][9000] - expected[1][4848] > -0.1);
  CHECK(expected[1][12000] < expected[1][9048] - 0.01);
}

TEST_CASE("world link: an edit that changes nothing changes no bit of a link", "[physics]") {
  const auto text = link_graph(kLinkPool, kLinkRead);
  const auto engine = engine_of(text);
  engine->set_journal(link_changes(*engine));
  const int frames = 18000;
  const auto expected = link_run(*engine, frames);
  const std::int64_t edit = GENERATE(5003, 8000, 15011);
  const auto edited = engine_of(text);
  REQUIRE(edited->prepare({edited->plan().sample_rate, 1, edited->out_channels(), 64}));
  edited->set_journal(link_changes(*edited));
  REQUIRE(edited->replace(*compile(parse_graph_leniently(text, "test.toml"), standard_nodes(), {}), edit));
  Channels out(kLinkRead.size(), std::vector<double>(static_cast<std::size_t>(frames)));
  const std::vector<double> input(60, 0.0);
  const double* in[] = {input.data()};
  const NoDenormals no_denormals;
  for (int done = 0; done < frames; done += 60) {
    std::vector<double*> to;
    for (auto& channel : out) to.push_back(channel.data() + done);
    edited->process({in, to.data(), 60});
  }
  CHECK((out == expected));
}

TEST_CASE("world link: making and watching links allocates nothing", "[physics]") {
  const auto engine = engine_of(link_graph(kLinkPool, kLinkRead));
  auto changes = link_changes(*engine);
  for (auto& change : changes) change.frame += 512;
  engine->set_journal(changes);
  const int frames = 512;
  (void)link_run(*engine, frames);
  auto* source = bodies_of(*engine);
  REQUIRE(source != nullptr);
  source->watch_poses(true);
  source->watch_impacts(true);
  std::vector<double> input(frames, 0.0);
  Channels out(kLinkRead.size(), std::vector<double>(frames));
  std::vector<double*> to;
  for (auto& channel : out) to.push_back(channel.data());
  const double* in[] = {input.data()};
  const auto before = allocation_count();
  for (int block = 0; block < 30; ++block) engine->process({in, to.data(), frames});
  CHECK(allocation_count() == before);
}

TEST_CASE("world: a remote handle takes another body and lets it go", "[physics]") {
  const std::string ball =
      " = { type = \"sphere\", radius = \"2 cm\", mass = \"30 g\", collides = \"none\", ";
  const auto engine = engine_of(link_graph(
      "one" + ball + "x = \"0 m\" }\ntwo" + ball + "x = \"20 cm\" }\n" +
          "hand = { type = \"handle\", on = \"one\", x = \"0.1 m\", stiffness = \"30 N/m\", damping = "
          "\"2 N s/m\", remote = \"yes\" }\n",
      {"w.one.x / 1 m", "w.two.x / 1 m", "w.hand.fx / 1 N"}));
  LinkJournal journal{*engine};
  journal.set(48000, "w_hand_holds", 2);
  journal.set(96000, "w_hand_holds", 0);
  engine->set_journal(journal.all());
  const auto out = link_run(*engine, 100000);
  CHECK(out[0][47999] == Approx(0.1).epsilon(1e-3));  // over-damped: 2 N s/m over 30 N/m
  CHECK(out[1][47999] == 0.2);
  CHECK(out[2][48001] == Approx(30 * 0.1));
  CHECK(out[1][95999] == Approx(0.1).epsilon(1e-3));
  CHECK(out[2][96001] == 0.0);
  CHECK(out[0][99999] == Approx(0.1).epsilon(1e-3));
}

TEST_CASE("world: what is watched are the bodies after the last step and their impacts", "[physics]") {
  const auto engine = engine_of(link_graph(
      kLinkFall + "ghost = { type = \"sphere\", radius = 1, mass = 1, collides = \"none\" }\n" +
          "floor = { type = \"plane\", normal = [0, 0, 1], offset = \"-1 m\" }\n" +
          "block = { type = \"box\", width = \"4 cm\", depth = \"2 cm\", height = \"2 cm\", mass = 1, "
          "turn = [0, 0, 1.5707963267948966] }\n",
      {"w.block.z / 1 m"}));
  auto* source = bodies_of(*engine);
  REQUIRE(source != nullptr);
  const auto& looks = source->looks();
  REQUIRE(looks.bodies.size() == 2);  // the ghost is left out
  CHECK(looks.bodies[0].name == "floor");
  CHECK(looks.bodies[0].offset == -1.0);
  CHECK(looks.bodies[1].shape == "box");
  CHECK(looks.bodies[1].number == 3);
  BodyPoses poses;
  BodyImpact impact;
  const auto idle = link_run(*engine, 96);
  CHECK_FALSE(source->take_poses(poses));  // nobody watched
  source->watch_poses(true);
  source->watch_impacts(true);
  const auto out = link_run(*engine, 24001);
  REQUIRE(source->take_poses(poses));
  CHECK_FALSE(source->take_poses(poses));
  REQUIRE(poses.bodies.size() == 2);
  const auto& block = poses.bodies[1];
  CHECK(poses.frame == 24000);
  CHECK(block.size == std::array{0.04, 0.02, 0.02});
  CHECK(block.turn[0] == Approx(std::sqrt(0.5)).epsilon(1e-6));
  CHECK(block.turn[3] == Approx(std::sqrt(0.5)).epsilon(1e-6));
  // The floor is reached after sqrt(2 * 0.99 / 9.81) = 0.449 s: it has hit, and rests.
  CHECK(block.position[2] == Approx(-0.99).margin(0.005));
  REQUIRE(source->take_impact(impact));
  CHECK(impact.one == 0);
  CHECK(impact.other == 1);
  CHECK(impact.speed == Approx(std::sqrt(2 * kLinkGravity * 0.99)).epsilon(0.01));
  CHECK(impact.frame == Approx(0.449 * 48000).epsilon(0.01));
}

#endif
