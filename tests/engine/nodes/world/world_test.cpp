#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <set>

#include "engine/runtime/player.h"
#include "tests/support/allocation_count.h"
#include "tests/support/graphs/graph_runner.h"

#if defined(TACTUS_HAS_ODE)

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kGravity = 9.81, kRate = 48000, kStep_s = 1e-3;
constexpr int kFrames = 48;  // of a step

const std::string kFall = "gravity = { type = \"gravity\" }\n";

std::string world_graph(const std::string& elements, const std::vector<std::string>& read,
                        const std::string& nodes = "") {
  std::string text = "format = 1\nname = \"n\"\n[inputs]\nx = {}\n[worlds.w]\n" + elements + "[nodes]\n" +
                     nodes + "[outputs]\n";
  for (std::size_t i = 0; i < read.size(); ++i)
    text += "out" + std::to_string(i) + " = { from = \"" + read[i] + "\" }\n";
  return text;
}

std::string world_ball(const std::string& name, const std::string& more) {
  return name + " = { type = \"sphere\", radius = \"2 cm\", " + more + " }\n";
}

Channels world_run(const std::string& text, int frames, const std::vector<int>& blocks = {64},
                   const std::vector<double>& input = {}) {
  auto samples = input;
  samples.resize(static_cast<std::size_t>(frames), input.empty() ? 0.0 : input.back());
  return run(*engine_of(text), {samples}, frames, blocks);
}

/// A ball that hits another one, bounces off a wall, turns a rod about a hinge and pushes a block with
/// friction; a handle joins in.
const std::string kBusy =
    kFall +
    "floor = { type = \"plane\", normal = [0, 0, 1], restitution = 0.6 }\n"
    "wall = { type = \"box\", body = \"fixed\", width = \"2 cm\", depth = \"1 m\", height = \"1 m\", mass = "
    "\"1 kg\", x = \"30 cm\", z = \"50 cm\" }\n" +
    world_ball("one", "mass = \"30 g\", z = \"5 cm\", vx = \"2 m/s\", vz = \"1 m/s\"") +
    world_ball("two", "density = \"2000 kg/m^3\", x = \"15 cm\", z = \"4 cm\", y = \"5 mm\"") +
    "block = { type = \"box\", width = \"5 cm\", depth = \"4 cm\", height = \"3 cm\", mass = \"80 g\", x = "
    "\"-10 cm\", z = \"1.6 cm\", turn = [0, 0, 0.3] }\n"
    "rod = { type = \"capsule\", radius = \"5 mm\", length = \"20 cm\", mass = \"0.1 kg\", x = \"20 cm\", y "
    "= \"20 cm\", z = \"30 cm\" }\n"
    "hinge = { type = \"hinge\", on = \"rod\", axis = [0, 1, 0], x = \"20 cm\", z = \"38 cm\", torque = "
    "\"0.1 N m * x\" }\n"
    "hand = { type = \"handle\", on = \"block\", x = \"-10 cm + 5 cm * x\", z = \"1.6 cm\", stiffness = "
    "\"300 N/m\", damping = \"1 N s/m\" }\n"
    "knock = { type = \"collision\", on = \"one\" }\n";
const std::vector<std::string> kBusyRead = {
    "w.one.x / 1 m",   "w.two.y / 1 m", "w.block.wz / 1 rad * 1 s",    "w.hinge / 1 rad",
    "w.hand.fx / 1 N", "w.knock.hit",   "w.knock.impulse / 1 N / 1 s", "w.knock.z / 1 m",
    "w.energy / 1 J",  "w.depth / 1 m"};

std::vector<double> wiggle(int frames) {
  std::vector<double> samples;
  for (int n = 0; n < frames; ++n) samples.push_back(std::sin(2 * kPi * 3.0 * n / kRate));
  return samples;
}

}  // namespace

TEST_CASE("world: a body falls as semi-implicit Euler says and moves on a line between two steps",
          "[physics]") {
  const auto z =
      world_run(world_graph(kFall + world_ball("ball", "mass = \"30 g\""), {"w.ball.z / 1 m"}), 48000)[0];
  const auto at = [](double steps) { return -kGravity * kStep_s * kStep_s * steps * (steps + 1) / 2; };
  for (const int step : {0, 1, 10, 500, 999}) {
    const auto frame = static_cast<std::size_t>(step * kFrames);
    CHECK(z[frame] == Approx(at(step)).epsilon(1e-12).margin(1e-15));
    CHECK(z[frame + 12] == Approx(0.75 * at(step) + 0.25 * at(step + 1)).epsilon(1e-12));
  }
}

TEST_CASE("world: a pendulum has the period of its moment of inertia", "[physics]") {
  const double length = 0.2, radius = 0.02, turned = 0.1;
  const auto text =
      world_graph(kFall +
                      world_ball("bob", "mass = \"30 g\", x = " + std::to_string(length * std::sin(turned)) +
                                            ", z = " + std::to_string(-length * std::cos(turned))) +
                      "axle = { type = \"hinge\", on = \"bob\", axis = [0, 1, 0] }\n",
                  {"w.bob.x / 1 m", "w.energy / 1 J"});
  const auto out = world_run(text, 480000);
  std::vector<double> crossings;
  for (std::size_t n = 1; n < out[0].size(); ++n)
    if (out[0][n - 1] < 0 && out[0][n] >= 0)
      crossings.push_back((static_cast<double>(n) - out[0][n] / (out[0][n] - out[0][n - 1])) / kRate);
  REQUIRE(crossings.size() > 5);
  const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  // I = 2/5 m r^2 + m l^2;  T = 2 pi sqrt(I / (m g l)) (1 + a^2 / 16 + 11 a^4 / 3072)
  const double inertia = 0.4 * radius * radius + length * length;
  const double expected = 2 * kPi * std::sqrt(inertia / (kGravity * length)) *
                          (1 + turned * turned / 16 + 11 * std::pow(turned, 4) / 3072);
  CHECK(period == Approx(expected).epsilon(1e-4));
}

TEST_CASE("world: the impulse of an impact is that of the reduced mass and the restitution", "[physics]") {
  const double m1 = 0.03, m2 = 0.1, v = 1.5;
  const double e = GENERATE(0.0, 0.5, 1.0);
  const auto text = world_graph(
      "correction_speed = \"0 m/s\"\n" +
          world_ball("one", "mass = \"30 g\", vx = \"1.5 m/s\", restitution = " + std::to_string(e)) +
          world_ball("two", "mass = \"100 g\", x = \"5.03 cm\"") +
          "knock = { type = \"collision\", on = \"one\", against = \"two\" }\n",
      {"w.knock", "w.knock.impulse / 1 N / 1 s", "w.knock.speed * 1 s / 1 m", "w.knock.x / 1 m",
       "w.one.vx * 1 s / 1 m", "w.two.vx * 1 s / 1 m", "w.energy / 1 J"});
  const auto out = world_run(text, 4800);
  const double impulse = m1 * m2 / (m1 + m2) * (1 + e) * v;
  // The compliance of 1e-10 s/kg is 1e-7 / kg in a step, of the inverse reduced mass 43 / kg.
  CHECK(out[1].back() == Approx(impulse).epsilon(1e-8));
  CHECK(out[2].back() == Approx(v).epsilon(1e-12));
  CHECK(out[4].back() == Approx(v - impulse / m1).epsilon(1e-7).margin(1e-7));
  CHECK(out[5].back() == Approx(impulse / m2).epsilon(1e-8));
  // The first step whose positions overlap: 1.03 cm at 1.5 mm a step. Its end is one step later.
  const auto hits = std::count(out[0].begin(), out[0].end(), 1.0);
  const auto hit = std::find(out[0].begin(), out[0].end(), 1.0) - out[0].begin();
  CHECK(hits == 1);
  CHECK(hit == 7 * kFrames + 1);
  CHECK(out[3].back() == Approx(0.02 + 7 * 1.5e-3).margin(0.5e-3));
  // The kinetic energy of the relative motion is multiplied by the restitution squared.
  const double before = 0.5 * m1 * v * v, lost = 0.5 * m1 * m2 / (m1 + m2) * v * v * (1 - e * e);
  CHECK(out[6].front() == Approx(before).epsilon(1e-12));
  CHECK(out[6].back() == Approx(before - lost).epsilon(1e-6));
}

TEST_CASE("world: a block on an incline holds or slides as Coulomb says whatever its direction",
          "[physics]") {
  const double slope = 0.4, about = GENERATE(0.0, 0.7);
  const double mu = GENERATE(0.2, 0.6);
  const double c = std::cos(about), s = std::sin(about);
  const auto number = [](double value) { return std::to_string(value); };
  const auto text = world_graph(
      kFall + "bounce_speed = 1\nslope = { type = \"plane\", friction = " + number(mu) + ", normal = [" +
          number(std::sin(slope) * c) + ", " + number(std::sin(slope) * s) + ", " + number(std::cos(slope)) +
          "] }\nblock = { type = \"box\", width = \"8 cm\", depth = \"8 cm\", height = \"2 cm\", mass = "
          "\"0.2 kg\", friction = " +
          number(mu) + ", x = " + number(0.01 * std::sin(slope) * c) +
          ", y = " + number(0.01 * std::sin(slope) * s) + ", z = " + number(0.01 * std::cos(slope)) +
          ", turn = [" + number(-slope * s) + ", " + number(slope * c) + ", 0] }\n",
      {"w.block.x / 1 m", "w.block.y / 1 m", "w.block.z / 1 m"});
  const auto out = world_run(text, 24000);
  const double went = std::hypot(out[0].back() - out[0].front(), out[1].back() - out[1].front(),
                                 out[2].back() - out[2].front());
  const double acceleration = std::max(0.0, kGravity * (std::sin(slope) - mu * std::cos(slope)));
  const double steps = 23999.0 / kFrames;
  CHECK(went ==
        Approx(acceleration * kStep_s * kStep_s * steps * (steps + 1) / 2).epsilon(0.01).margin(1e-4));
}

TEST_CASE("world: the output does not depend on the block size and a second run repeats the first",
          "[physics]") {
  const std::string solver = GENERATE("direct", "iterative");
  const auto text = world_graph("solver = \"" + solver + "\"\n" + kBusy, kBusyRead);
  const int frames = 30000;
  const auto input = wiggle(frames);
  const auto engine = engine_of(text);
  const auto expected = run(*engine, {input}, frames, {64});
  CHECK(std::count(expected[5].begin(), expected[5].end(), 1.0) > 2);
  CHECK(run(*engine, {input}, frames, {64}) == expected);
  for (const auto& blocks : {std::vector{1}, std::vector{1000}, std::vector{7, 48, 300}})
    CHECK(world_run(text, frames, blocks, input) == expected);
}

TEST_CASE("world: no step allocates", "[physics]") {
  const std::string solver = GENERATE("direct", "iterative");
  const auto engine = engine_of(world_graph("solver = \"" + solver + "\"\n" + kBusy, kBusyRead));
  const int frames = 512;
  (void)run(*engine, {wiggle(frames)}, frames, {frames});
  std::vector<double> input(frames, 0.5);
  std::vector<std::vector<double>> out(kBusyRead.size(), std::vector<double>(frames));
  std::vector<double*> to;
  for (auto& channel : out) to.push_back(channel.data());
  const double* in[] = {input.data()};
  const auto before = allocation_count();
  for (int block = 0; block < 40; ++block) engine->process({in, to.data(), frames});
  CHECK(allocation_count() == before);
}

TEST_CASE("world: an edit that changes nothing changes no bit", "[physics]") {
  const auto text = world_graph(kBusy, kBusyRead);
  const int frames = 24000;
  const auto expected = world_run(text, frames, {64}, wiggle(frames));
  const auto engine = engine_of(text);
  StreamFormat format{engine->plan().sample_rate, 1, engine->out_channels(), 64};
  REQUIRE(engine->prepare(format));
  REQUIRE(engine->replace(*compile(parse_graph_leniently(text, "test.toml"), standard_nodes(), {}), 9611));
  const auto input = wiggle(frames);
  Channels out(kBusyRead.size(), std::vector<double>(static_cast<std::size_t>(frames)));
  const NoDenormals no_denormals;
  for (int done = 0; done < frames; done += 60) {
    const double* in[] = {input.data() + done};
    std::vector<double*> to;
    for (auto& channel : out) to.push_back(channel.data() + done);
    engine->process({in, to.data(), 60});
  }
  CHECK(out == expected);
}

TEST_CASE("world: a handle gives its body the impulse of the force that it gets", "[physics]") {
  const auto text =
      world_graph(world_ball("ball", "mass = \"30 g\"") +
                      "hand = { type = \"handle\", on = \"ball\", x = \"1 cm * x\", stiffness = \"200 N/m\", "
                      "damping = \"0.5 N s/m\", passivity = \"0 N s/m\" }\n",
                  {"w.hand.fx / 1 N", "w.ball.vx * 1 s / 1 m", "w.hand.fy / 1 N"});
  const int frames = 200 * kFrames + 1;  // the last one is that of a step
  const auto input = wiggle(frames + 1);
  const auto out = world_run(text, frames + 1, {64}, input);
  double impulse = 0;
  for (int n = 0; n < frames; ++n) impulse -= out[0][static_cast<std::size_t>(n)] / kRate;
  CHECK(out[1].back() == Approx(impulse / 0.03).epsilon(1e-10));
  CHECK(*std::max_element(out[2].begin(), out[2].end()) == 0.0);
}

TEST_CASE("world: a handle on a body that is held is a spring", "[physics]") {
  const auto text = world_graph(
      world_ball("ball", "mass = \"30 g\"") +
          "bolt = { type = \"fixed\", on = \"ball\" }\n"
          "hand = { type = \"handle\", on = \"ball\", x = \"1 cm * x\", stiffness = \"200 N/m\" }\n",
      {"w.hand / 1 N"});
  CHECK(world_run(text, 4800, {64}, {1.0})[0].back() == Approx(-2.0).epsilon(1e-3));
}

TEST_CASE("world: the passivity controller keeps a stiff coupling from gaining energy", "[physics]") {
  // A hand of 100 g, free, on a spring of 1,000 N/m that acts with half a step's delay.
  const auto text = [](const std::string& passivity) {
    return "format = 1\nname = \"n\"\n[inputs]\nx = {}\n[worlds.w]\n" +
           world_ball("ball", "mass = \"20 g\"") +
           "hand = { type = \"handle\", on = \"ball\", x = \"hand.mass\", stiffness = \"1000 N/m\", "
           "passivity = \"" +
           passivity +
           " N s/m\" }\n[networks.hand]\nmass = { type = \"mass\", mass = \"100 g\", velocity = \"0.1 m/s\" "
           "}\n"
           "push = { type = \"force\", on = \"mass\", force = \"w.hand.fx\" }\n[outputs]\nenergy = { from = "
           "\"(hand.energy + w.energy) / 1 J\" }\n"
           "gap = { from = \"(hand.mass - w.ball.x) / 1 m\" }\n";
  };
  const double energy = 0.5 * 0.1 * 0.01;
  const auto total = [](const Channels& out) { return out[0].back() + 500 * out[1].back() * out[1].back(); };
  CHECK(total(world_run(text("0"), 48000)) > 2 * energy);
  // A step generates at most about (w h)^2 of the energy, w^2 = k (1 / m1 + 1 / m2), and twice before it is
  // removed.
  const double bound = energy * (1 + 2 * 1000 * (1 / 0.1 + 1 / 0.02) * kStep_s * kStep_s);
  const auto out = world_run(text("5"), 48000);
  for (std::size_t n = 0; n < out[0].size(); n += 100) CHECK(out[0][n] + 500 * out[1][n] * out[1][n] < bound);
}

TEST_CASE("world: a body can be put elsewhere and be absent", "[physics]") {
  const auto text = world_graph(kFall + world_ball("ball",
                                                   "mass = \"30 g\", z = \"1 m\", place = \"x > 0.5\", "
                                                   "launch = \"x > 0.5\", present = \"x >= -0.5\""),
                                {"w.ball.z / 1 m", "w.energy / 1 J"});
  std::vector<double> input(48000, 0.0);
  input[10005] = 1.0;  // for one frame, between two steps
  std::fill(input.begin() + 20000, input.begin() + 30000, -1.0);
  const auto out = world_run(text, 48000, {64}, input);
  const auto at = [](double steps) { return 1 - kGravity * kStep_s * kStep_s * steps * (steps + 1) / 2; };
  CHECK(out[0][10000 / kFrames * kFrames] == Approx(at(208)));
  const int put = (10005 / kFrames + 1) * kFrames;
  CHECK(out[0][static_cast<std::size_t>(put + 100 * kFrames)] == Approx(at(100)));
  CHECK(out[1][25000] == 0.0);
  CHECK(out[0][25000] == out[0][29000]);
  const int back = (30000 / kFrames) * kFrames;
  CHECK(out[0][static_cast<std::size_t>(back + 200 * kFrames)] == Approx(at(200)));
}

TEST_CASE("world: what acts on nothing that is read is left out", "[physics]") {
  const auto left = [](const std::string& elements, const std::vector<std::string>& read) {
    std::set<std::string> all;
    const auto engine = engine_of(world_graph(elements, read));
    for (const auto& [path, reason] : engine->plan().left_out)
      if (path != "x") all.insert(path + ": " + reason);
    return all;
  };
  using Left = std::set<std::string>;
  const auto ghosts = kFall + world_ball("seen", "mass = \"30 g\", collides = \"none\"") +
                      world_ball("ghost", "mass = \"30 g\", collides = \"none\"") +
                      "pull = { type = \"handle\", on = \"ghost\", x = \"1 mm * x\", stiffness = 1 }\n";
  CHECK(left(ghosts, {"w.seen.z / 1 m"}) == Left{"w.ghost: reaches no output", "w.pull: reaches no output"});
  CHECK(left(ghosts, {"w.energy / 1 J"}).empty());
  const auto touching = kFall + world_ball("one", "mass = \"30 g\"") + world_ball("two", "mass = \"30 g\"") +
                        world_ball("never", "mass = \"30 g\", present = 0") +
                        "knock = { type = \"collision\", on = \"two\" }\n";
  CHECK(left(touching, {"w.one.z / 1 m"}) == Left{"w.knock: reaches no output", "w.never: is never present"});
  const auto watched = "floor = { type = \"plane\", normal = [0, 0, 1] }\n" + world_ball("ball", "mass = 1") +
                       world_ball("ghost", "mass = 1, collides = \"none\"") +
                       "landing = { type = \"collision\", on = \"floor\" }\n";
  CHECK(left(watched, {"w.landing.hit"}) == Left{"w.ghost: reaches no output"});
  CHECK(left(touching, {"x"}).contains("w: reaches no output"));
}

TEST_CASE("world: a remote body has controls for what the file leaves out or gives as a number",
          "[physics]") {
  const auto engine = engine_of(
      world_graph(world_ball("ball", "mass = \"30 g\", remote = \"yes\", present = 0, y = \"1 m * x\"") +
                      "gravity = { type = \"gravity\", remote = \"yes\", z = \"-1 m/s^2\" }\n",
                  {"w.ball.z / 1 m", "w.ball.x / 1 m"}));
  const auto& names = engine->control_names();
  const auto has = [&](const char* name) { return std::ranges::find(names, name) != names.end(); };
  for (const char* name : {"w_ball_x", "w_ball_radius", "w_ball_mass", "w_ball_present", "w_gravity_z"}) {
    INFO(name);
    CHECK(has(name));
  }
  CHECK_FALSE(has("w_ball_y"));
  CHECK_FALSE(has("w_ball_friction"));
  using Kind = JournalEntry::Kind;
  std::vector<JournalEntry> journal;
  const auto change = [&](std::int64_t frame, const char* name, double value) {
    journal.push_back({frame, Kind::ControlChange, engine->control_index(name), value});
  };
  change(4800, "w_ball_x", 0.25);
  change(4800, "w_ball_vx", 2.0);
  change(4800, "w_ball_present", 1.0);
  engine->set_journal(journal);
  const auto out = run(*engine, {std::vector<double>(9601, 0.0)}, 9601, {64});
  // 100 steps later, and one that begins at the same frame.
  CHECK(out[0][4800] == 0.0);
  CHECK(out[0][9600] == Approx(-1.0 * kStep_s * kStep_s * 100 * 101 / 2));
  CHECK(out[1][9600] == Approx(0.25 + 2.0 * 100 * kStep_s));
}

TEST_CASE("world: errors name the element and what it lacks", "[physics]") {
  const auto errors = [](const std::string& elements) {
    return errors_of("format = 1\nname = \"n\"\n[worlds.w]\n" + elements);
  };
  const auto ball = world_ball("ball", "mass = 1");
  const std::string floor = "floor = { type = \"plane\", normal = ";
  CHECK(errors("") == "test.toml:3:9 Missing 'w' ball type \"sphere\" radius \"2 cm\" mass \"30 g\"");
  CHECK(errors("ball = { type = \"spere\" }\n") == "test.toml:4:17 UnknownName 'spere' 'sphere'");
  CHECK(errors("ball = { type = \"sphere\", radius = 0.1 }\n") ==
        "test.toml:4:1 Missing 'ball' 'mass' 'density'");
  CHECK(errors("ball = { type = \"sphere\", radius = 0.1, mass = 1, density = 2 }\n") ==
        "test.toml:4:61 Duplicate 'ball' 'mass' 'density'");
  CHECK(errors(floor + "[0, 0, 0] }\n") == "test.toml:4:36 OutOfRange 'normal' 'floor' 0 0 0 1");
  CHECK(errors(floor + "[0, 1] }\n") == "test.toml:4:36 WrongType 'normal' 'floor'");
  CHECK(errors(ball + "pin = { type = \"ball\", on = \"bal\" }\n") ==
        "test.toml:5:29 UnknownName 'w' 'bal' 'ball'");
  CHECK(errors(ball + "pin = { type = \"ball\" }\n") == "test.toml:5:1 Missing 'pin' 'on'");
  CHECK(errors(ball + "pin = { type = \"ball\", on = \"ball\", against = \"ball\" }\n") ==
        "test.toml:5:1 Duplicate 'pin'");
  CHECK(errors(floor + "[0, 0, 1] }\npush = { type = \"fixed\", on = \"floor\" }\n") ==
        "test.toml:5:31 WrongType 'floor' 'push'");
  CHECK(errors("rate = 0\n" + ball) == "test.toml:4:8 OutOfRange 'rate' 0 1 1000");
  CHECK(errors("stiffness = 100\ndamping = 1\nerp = 0.5\n" + ball) ==
        "test.toml:6:7 Duplicate 'w' 'stiffness' 'erp'");
  CHECK(errors("stiffness = 100\n" + ball) == "test.toml:3:9 Missing 'w' 'damping' 'stiffness' 'damping'");
  CHECK(errors(world_ball("energy", "mass = 1")) == "test.toml:4:1 Duplicate 'energy' 'w.energy'");
}

#else

TEST_CASE("world: a build without the library names what to install") {
  CHECK(tactus::test::full_errors_of(
            "format = 1\nname = \"n\"\n[worlds.w]\nball = { type = \"sphere\", radius = 1, mass = 1 }\n")
            .find("libode-dev") != std::string::npos);
}

#endif
