#include "engine/runtime/player.h"

#include <catch2/catch.hpp>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using test::engine_of;

namespace {

using Kind = JournalEntry::Kind;

constexpr int kFrames = 6000;

std::string graph(const std::string& body) { return "format = 1\nname = \"test\"\n" + body; }

const std::string kHead = R"(
[inputs]
x = {}
go = {}
[controls]
level  = { value = "-6 dB", range = ["-40 dB", "0 dB"] }
gain   = { value = 0.4, range = [-0.5, 0.5], smooth = "7 ms" }
switch = { value = 0.25, range = [-1, 1], smooth = "0 ms" }
corner = { value = "800 Hz", range = ["50 Hz", "9 kHz"], smooth = "3 ms" }
)";

/// A graph with a loop whose delay is so many frames.
std::string loop_of(int frames) {
  return graph(kHead + "[nodes]\npulse = { type = \"decay\", trigger = \"go\", time = \"3 ms\" }\n" +
               "y = \"level * x + pulse + gain * loss.low\"\n" +
               "loss = { type = \"one_pole\", in = \"line\", cutoff = \"corner\" }\n" +
               "line = { type = \"delay\", in = \"y\", interpolation = \"none\", time = \"" +
               std::to_string(frames) + " / system.rate\" }\n" +
               "[outputs]\ny = { from = \"y\" }\nc = { from = \"switch\" }\nl = { from = \"level\" }\n");
}

const std::string kModulated = graph(kHead + R"(
[nodes]
wobble = { type = "sine", frequency = "31 Hz", level = "0.4 ms" }
y      = "x + gain * line + switch * go"
line   = { type = "delay", in = "y", time = "1 ms + wobble" }
fifth  = { type = "delay", in = "y - 0.3 * fifth", time = "0.31 ms", interpolation = "lagrange5" }
[outputs]
y = { from = "y" }
z = { from = "fifth * level" }
)");

const std::string kNested = graph(kHead + R"(
[nodes]
inner = { type = "delay", in = "x + gain * inner + 0.3 * outer", time = "5 / system.rate", interpolation = "none" }
band  = { type = "low_pass", in = "inner", cutoff = "corner", q = 0.7 }
outer = { type = "delay", in = "band + switch * go", time = "17 / system.rate", interpolation = "none" }
far   = { type = "delay", in = "outer + 0.2 * far", time = "200 / system.rate", interpolation = "none" }
one   = { type = "delay", in = "level * far - 0.4 * one", time = "1 / system.rate", interpolation = "none" }
[outputs]
y = { from = "outer" }
z = { from = "one" }
)");

const std::string kNetwork = graph(kHead + R"(
[networks.coil]
frame = { type = "ground" }
cone  = { type = "mass", mass = "35 g" }
stick = { type = "mass", mass = "12 g", at = "1 mm" }
hold  = { type = "spring", between = ["frame", "cone"], stiffness = "1000 N/m", damping = "1.2 kg/s" }
lens  = { type = "contact", between = ["cone", "stick"], stiffness = "5e6 N/m^1.5", loss = "0.15 s/m" }
push  = { type = "force", on = "cone", force = "2 N * (x + switch * go) - 20 N s/m * coil.cone.velocity" }
fall  = { type = "force", on = "stick", force = "-1 N" }
[nodes]
filtered = { type = "band_pass", in = "coil.lens.force / 1 N", frequency = "corner", q = 0.7 }
hit   = { type = "threshold", in = "filtered", level = "level" }
count = { type = "counter", trigger = "hit", count = 7 }
[outputs]
y = { from = "filtered" }
n = { from = "count" }
p = { from = "coil.stick.position", unit = "m" }
)");

const std::string kLanes = graph(kHead + R"(
[nodes]
tunes = { type = "delay", voices = 3, in = "x + switch * go + 0.4 * loss", time = { from = "1 ms", to = "4 ms" } }
loss  = { type = "one_pole", in = "tunes", cutoff = ["900 Hz", "2 kHz", "corner"] }
hiss  = { type = "noise", level = ["level", "gain"] }
all   = { type = "mix", in = "loss" }
[outputs]
each = { from = "loss" }
all  = { from = "all" }
hiss = { from = "hiss" }
)");

test::Channels inputs() {
  auto go = test::Samples(kFrames);
  for (const int frame : {0, 1, 63, 64, 77, 777, 1501, 1502, 4095, 4097})
    go[static_cast<std::size_t>(frame)] = 1;
  return {test::noise(kFrames, 7), go};
}

/// Changes at frames that lie on no block of any size, on top of one another, and in the middle of ramps.
std::vector<JournalEntry> changes(const Plan& schedule) {
  std::vector<JournalEntry> entries;
  const auto add = [&](std::int64_t frame, const char* name, double value) {
    entries.push_back({frame, Kind::ControlChange, schedule.control_index(name), value});
  };
  add(0, "gain", -0.2);
  add(1, "switch", -0.5);
  add(37, "corner", 5000);
  add(101, "level", 0.9);
  add(103, "level", 0.02);
  add(103, "corner", 70);
  add(337, "gain", 0.45);
  add(337, "gain", 0.1);
  add(999, "switch", 0.7);
  add(1000, "switch", 0.1);
  add(1001, "corner", 8000);
  add(2049, "level", 0.5);
  add(4097, "gain", 0.5);
  return entries;
}

void check_blocks(const std::string& text) {
  auto engine = engine_of(text);
  const auto play = [&](const std::vector<int>& blocks) {
    engine->set_journal(changes(engine->plan()));
    return test::run(*engine, inputs(), kFrames, blocks);
  };
  const auto expected = play({1});
  double loudest = 0;
  for (const double sample : expected[0]) loudest = std::max(loudest, std::abs(sample));
  CHECK(loudest > 1e-6);  // silence would be the same in any block
  CHECK(engine->faults().empty());
  for (const int block : {2, 3, 7, 16, 63, 64, 65, 100, 256, 1000, 4096}) {
    INFO("blocks of " << block);
    CHECK(test::first_difference(expected, play({block})) == "");
  }
  CHECK(test::first_difference(expected, play({1, 64, 3, 200, 17, 4096, 5})) == "");
}

}  // namespace

TEST_CASE("Player: the block size changes no bit of a loop", "[runtime]") {
  for (const int frames : {1, 5, 17, 200}) {
    INFO("delay of " << frames << " frames");
    check_blocks(loop_of(frames));
  }
}

TEST_CASE("Player: the block size changes no bit of moving delays, nested loops, networks, lanes",
          "[runtime]") {
  SECTION("moving delays") { check_blocks(kModulated); }
  SECTION("nested loops") { check_blocks(kNested); }
  SECTION("a network in a loop") { check_blocks(kNetwork); }
  SECTION("lanes") { check_blocks(kLanes); }
}

TEST_CASE("Player: the block size changes no bit of parts", "[runtime]") {
  const test::TemporaryFolder folder;
  folder.write("comb.toml", graph(R"(
[inputs]
in = {}
[controls]
amount = { value = 0.5, range = [-0.9, 0.9] }
[nodes]
line = { type = "delay", in = "in + amount * line", time = "0.37 ms" }
[outputs]
out = { from = "line" }
)"));
  const auto spec = load_graph(folder.write("whole.toml", graph(kHead + R"(
[nodes]
comb = { use = "comb.toml", in = "x + switch * go + 0.3 * back", amount = "gain" }
back = { type = "delay", in = "comb.out", time = "2.1 ms" }
[outputs]
y = { from = "comb.out * level" }
)")));
  REQUIRE(spec);
  auto compiled = compile(**spec, standard_nodes(), {});
  REQUIRE(compiled);
  Player engine{std::move(*compiled)};
  const auto play = [&](const std::vector<int>& blocks) {
    engine.set_journal(changes(engine.plan()));
    return test::run(engine, inputs(), kFrames, blocks);
  };
  const auto expected = play({1});
  for (const int block : {2, 63, 64, 65, 1000, 4096})
    CHECK(test::first_difference(expected, play({block})) == "");
}

TEST_CASE("Player: a loop of d frames runs min(64, d) at a time and gives the recurrence bit for bit",
          "[runtime]") {
  for (const int d : {1, 2, 5, 17, 63, 64, 65, 200}) {
    INFO("d = " << d);
    const auto engine =
        engine_of(graph("[inputs]\nx = {}\n[nodes]\ny = \"x + 0.7 * line\"\n"
                        "line = { type = \"delay\", in = \"y\", time = \"" +
                        std::to_string(d) +
                        " / system.rate\", interpolation = \"none\" }\n"
                        "[outputs]\ny = { from = \"y\" }\n"));
    const auto& loops = engine->plan().loops;
    REQUIRE(loops.size() == 1);
    CHECK(loops[0].sub_block == std::min(64, d));
    CHECK(loops[0].delay_frames == d);
    const auto x = test::noise(2000, 3);
    test::Samples y(x.size());
    for (std::size_t n = 0; n < y.size(); ++n)
      y[n] = x[n] + 0.7 * (n >= static_cast<std::size_t>(d) ? y[n - static_cast<std::size_t>(d)] : 0.0);
    CHECK(test::first_difference({y}, test::run(*engine, {x}, 2000, {256, 1, 77})) == "");
  }
}

TEST_CASE("Player: two loops through one sum run at the shorter delay, bit for bit", "[runtime]") {
  const auto engine = engine_of(graph(R"([inputs]
x = {}
[nodes]
y = "(x + 0.5 * a) + 0.25 * b"
a = { type = "delay", in = "y", time = "3 / system.rate", interpolation = "none" }
b = { type = "delay", in = "y", time = "50 / system.rate", interpolation = "none" }
[outputs]
y = { from = "y" }
)"));
  REQUIRE(engine->plan().loops.size() == 1);
  CHECK(engine->plan().loops[0].sub_block == 3);
  const auto x = test::noise(1000, 5);
  test::Samples y(x.size());
  for (std::size_t n = 0; n < y.size(); ++n)
    y[n] = (x[n] + 0.5 * (n >= 3 ? y[n - 3] : 0)) + 0.25 * (n >= 50 ? y[n - 50] : 0);
  CHECK(test::first_difference({y}, test::run(*engine, {x}, 1000, {128})) == "");
}

TEST_CASE("Player: what is left out changes no bit", "[runtime]") {
  const std::string kept = R"(
y    = "level * x + gain * line"
line = { type = "delay", in = "y", time = "23 / system.rate" }
)";
  const std::string outputs = "[outputs]\ny = { from = \"y\" }\n";
  const std::string branches = R"(
lost   = { type = "low_pass", in = "y", cutoff = "corner", q = 2 }
loop   = { type = "delay", in = "lost + 0.5 * loop", time = "2 ms" }
silent = "0 * loop"
)";
  const auto play = [](const std::string& text) {
    const auto engine = engine_of(text);
    engine->set_journal(changes(engine->plan()));
    return test::run(*engine, inputs(), kFrames, {100});
  };
  const auto expected = play(graph(kHead + "[nodes]" + kept + outputs));
  CHECK(test::first_difference(expected, play(graph(kHead + "[nodes]" + branches + kept + outputs))) == "");
  const auto with_zero = "[outputs]\ny = { from = \"1 * y + silent\" }\n";
  CHECK(test::first_difference(expected, play(graph(kHead + "[nodes]" + branches + kept + with_zero))) == "");
}

TEST_CASE("Player: system.rate and system.delay are what the stream has", "[runtime]") {
  const auto text = graph(R"([inputs]
x = {}
[nodes]
late = { type = "delay", in = "x", time = "system.delay", max = "50 ms" }
[outputs]
rate  = { from = "system.rate / 1 kHz" }
delay = { from = "system.delay * system.rate" }
late  = { from = "late" }
)");
  CompileOptions options;
  options.sample_rate = 96_kHz;
  options.system_delay = 1_ms;
  const auto engine = engine_of(text, options);
  engine->set_journal({{501, Kind::SystemDelay, 0, 7.0}, {901, Kind::SystemDelay, 0, -1.0}});
  auto x = test::Samples(1000);
  x[100] = x[600] = x[950] = 1;
  const auto out = test::run(*engine, {x}, 1000, {64});
  CHECK(out[0][0] == 96);
  CHECK(out[1][0] == Approx(96).epsilon(1e-12));
  CHECK(out[1][500] == Approx(96).epsilon(1e-12));
  CHECK(out[1][501] == Approx(7).epsilon(1e-12));
  CHECK(out[1][901] == Approx(7).epsilon(1e-12));  // no longer known: the last one is the best guess
  CHECK(out[2][196] == Approx(1).epsilon(1e-12));
  CHECK(out[2][607] == Approx(1).epsilon(1e-12));
  CHECK(out[2][957] == Approx(1).epsilon(1e-12));
}

TEST_CASE("Player: controls ramp from their frame, in decibels where they are read so", "[runtime]") {
  const auto engine = engine_of(graph(R"([controls]
plain = { value = 0, range = [0, 1] }
db    = { value = "-40 dB", range = ["-40 dB", "0 dB"] }
now   = { value = 0, range = [0, 1], smooth = "0 ms" }
[outputs]
plain = { from = "plain" }
db    = { from = "db" }
now   = { from = "now" }
)"));
  const auto entry = [&](const char* name, double value) {
    return JournalEntry{101, Kind::ControlChange, engine->plan().control_index(name), value};
  };
  engine->set_journal({entry("plain", 1), entry("db", 1), entry("now", 2)});
  const auto out = test::run(*engine, {}, 1000, {333});
  // 10 ms are 480 frames.
  CHECK(out[0][100] == 0);
  CHECK(out[0][101 + 120] == Approx(0.25).epsilon(1e-12));
  CHECK(out[0][101 + 480] == 1);
  CHECK(out[1][101 + 240] == Approx(0.1).epsilon(1e-12));
  CHECK(out[1][101 + 480] == 1);
  CHECK(out[2][100] == 0);
  CHECK(out[2][101] == 1);  // clamped to its range
}
