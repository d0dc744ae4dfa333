#include <catch2/catch.hpp>
#include <cmath>

#include "engine/runtime/signal_scope.h"
#include "engine/scene/closed_loop.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"
#include "tests/support/graphs/voices_graph.h"

using namespace tactus;
using test::Channels;

namespace {

constexpr int kFrames = 4000;

std::unique_ptr<Player> engine_of(const std::string& text, bool vectorise) {
  CompileOptions options;
  options.vectorise = vectorise;
  return test::engine_of(text, options);
}

Channels noise_in() { return {test::noise(kFrames, 7, -0.2, 0.2)}; }

/// Largest difference over the largest sample.
double relative_difference(const Channels& a, const Channels& b) {
  double peak = 0, off = 0;
  REQUIRE(a.size() == b.size());
  for (std::size_t c = 0; c < a.size(); ++c)
    for (std::size_t n = 0; n < a[c].size(); ++n) {
      peak = std::max(peak, std::abs(a[c][n]));
      off = std::max(off, std::abs(a[c][n] - b[c][n]));
    }
  REQUIRE(peak > 0);
  return off / peak;
}

/// Side by side against one by one, and the block size against itself. Returns the engine that runs side by
/// side.
std::unique_ptr<Player> check_vectorised(const std::string& text, double tolerance = 1e-12,
                                         const std::vector<JournalEntry>& journal = {}) {
  auto wide = engine_of(text, true);
  auto scalar = engine_of(text, false);
  wide->set_journal(journal);
  scalar->set_journal(journal);
  const auto together = test::run(*wide, noise_in(), kFrames, {64});
  CHECK(relative_difference(test::run(*scalar, noise_in(), kFrames, {64}), together) <= tolerance);
  for (const std::vector<int>& blocks : {std::vector{1}, {17, 3, 64, 5}, {1024}})
    CHECK(test::first_difference(together, test::run(*wide, noise_in(), kFrames, blocks)) == "");
  CHECK(wide->faults().empty());
  return wide;
}

bool runs(const Player& engine, const std::string& path) {
  const auto& vertices = engine.plan().vertices;
  return std::any_of(vertices.begin(), vertices.end(), [&](const Vertex& v) { return v.path == path; });
}

/// Eight channels into filters that run side by side; `also` reads them as well.
std::string eight_channels(const std::string& also = "") {
  return "format = 1\n[inputs]\nx = { lanes = 8 }\n[nodes]\ny = { type = \"low_pass\", in = \"x\", cutoff = "
         "\"1 kHz\" }\n[outputs]\ny = { from = \"y\" }\n" +
         also;
}

Channels eight_noises() {
  Channels noises;
  for (unsigned channel = 0; channel < 8; ++channel)
    noises.push_back(test::noise(kFrames, 20 + channel, -1, 1));
  return noises;
}

int steps_of(const Plan& plan, const std::string& what) {
  return static_cast<int>(std::ranges::count_if(plan.steps, [&](const Step& step) {
    return step.vertex >= 0 && plan.vertices[index(step.vertex)].description() == what;
  }));
}

std::string body(const std::string& nodes, const std::string& before = "") {
  return "format = 1\n[inputs]\nx = {}\n" + before + "[nodes]\n" + nodes +
         "[outputs]\ny = { from = \"y\" }\n";
}

}  // namespace

TEST_CASE("side by side: any number of voices sounds as one by one", "[runtime]") {
  for (const bool one_node : {true, false})
    for (const int voices : {2, 5, 8, 9, 13, 16, 64}) {
      INFO(voices << " voices, one node: " << one_node);
      const auto engine = check_vectorised(test::voices_graph(voices, one_node));
      CHECK(runs(*engine, "y[0..7]") == (voices >= 8));
      CHECK(runs(*engine, "y[0..4]") == (voices == 5));
      CHECK(runs(*engine, "y[8..12]") == (voices == 13));
      CHECK(runs(*engine, "y[8]") == (voices == 9));
      CHECK(runs(*engine, "y[0]") == (voices == 2));
    }
}

TEST_CASE("side by side: 64 strings are 8 of each step", "[runtime]") {
  const auto engine = engine_of(test::voices_graph(64, true), true);
  std::vector<std::string> whats;
  for (const auto& vertex : engine->plan().vertices) whats.push_back(vertex.description());
  for (const auto* what : {"low_pass", "string", "clip"})
    CHECK(std::count(whats.begin(), whats.end(), what) == 8);
  CHECK(std::count(whats.begin(), whats.end(), "sum of lanes") == 1);
  CHECK(std::count(whats.begin(), whats.end(), "pack") == 0);
}

TEST_CASE("side by side: lanes are added in one order, wide or not", "[runtime]") {
  for (const int voices : {4, 6, 8, 11, 24, 29}) {
    // Delays of whole frames give the same bits side by side; so does the sum then.
    const auto text = body(
        "d = { type = \"delay\", in = \"x\", interpolation = \"none\", voices = " + std::to_string(voices) +
        ", time = { from = \"1 ms\", to = \"9 ms\" } }\n"
        "y = { type = \"mix\", in = \"d\" }\n");
    INFO(voices);
    CHECK(test::first_difference(test::run(*engine_of(text, true), noise_in(), kFrames, {64}),
                                 test::run(*engine_of(text, false), noise_in(), kFrames, {64})) == "");
  }
}

TEST_CASE("side by side: pitches move, by one control or one a lane", "[runtime]") {
  const std::string controls =
      "[controls]\nbend = { value = 1, range = [0.5, 2] }\na = { value = \"0.6 kHz\", range = [\"100 Hz\", "
      "\"2 "
      "kHz\"] }\nb = { value = \"0.9 kHz\", range = [\"100 Hz\", \"2 kHz\"] }\n";
  const std::vector<JournalEntry> journal = {{1001, JournalEntry::Kind::ControlChange, 0, 1.7},
                                             {1500, JournalEntry::Kind::ControlChange, 1, 1900.0},
                                             {2002, JournalEntry::Kind::ControlChange, 2, 130.0}};
  const std::string mix = "y = { type = \"mix\", in = \"m\" }\n";
  // As signals, a sample a frame.
  check_vectorised(
      body("v = { type = \"sine\", frequency = \"5 Hz\" }\n"
           "w = [0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08]\n"
           "t = \"1 + w * v\"\n"
           "d = { type = \"delay\", in = \"m\", time = \"4 ms * t\", min = \"2 ms\", max = \"6 ms\" }\n"
           "m = { type = \"one_pole\", in = \"x + 0.9 * d\", cutoff = \"4 kHz * t\" }\n" +
           mix));
  check_vectorised(body("w = [\"100 Hz\", \"120 Hz\", \"150 Hz\", \"200 Hz\", \"300 Hz\", \"310 Hz\", "
                        "\"320 Hz\", \"440 Hz\"]\n"
                        "p = \"bend * w\"\n"
                        "m = { type = \"string\", in = \"x\", pitch = \"p\" }\n" +
                            mix,
                        controls),
                   1e-12, journal);
  const auto engine = check_vectorised(
      body("m = { type = \"low_pass\", in = \"x\", q = \"bend\", cutoff = [\"a\", \"b\", \"a\", \"a + b\", "
           "\"1 kHz\", \"b\", \"a\", \"a\"] }\n" +
               mix,
           controls),
      1e-12, journal);
  CHECK(runs(*engine, "m[0..7]"));
}

TEST_CASE("side by side: scalars feed voices and hear single ones", "[runtime]") {
  // Noise has no wide form: its lanes are packed; a table of levels unpacks them again.
  const auto engine =
      check_vectorised(body("n = { type = \"noise\", voices = 8, level = { from = 0.1, to = 0.8 } }\n"
                            "m = { type = \"high_pass\", in = \"x + n\", cutoff = \"300 Hz\" }\n"
                            "h = { type = \"sample_hold\", in = \"m\", trigger = \"5 * x\" }\n"
                            "y = { type = \"mix\", in = \"h * m\" }\n"));
  CHECK(runs(*engine, "m[0..7]"));
  CHECK(runs(*engine, "h[3]"));
}

TEST_CASE("side by side: a voice that is left out does not keep the others apart", "[runtime]") {
  const auto engine = check_vectorised(body(
      "m = { type = \"low_pass\", in = \"x\", cutoff = { from = \"1 kHz\", to = \"8 kHz\" }, voices = 8 }\n"
      "w = [0, 1, 2, 3, 4, 5, 6, 7]\ny = { type = \"mix\", in = \"m * w\" }\n"));
  CHECK(runs(*engine, "m[0..7]"));
  const auto& left_out = engine->plan().left_out;
  CHECK(std::any_of(left_out.begin(), left_out.end(), [](const auto& left) { return left.path == "m[0]"; }));
}

TEST_CASE("side by side: outputs take their lanes straight from where they run", "[runtime]") {
  auto text = body(
      "y = { type = \"band_pass\", in = \"x\", frequency = { from = \"100 Hz\", to = \"3 kHz\", "
      "curve = \"exponential\" }, voices = 11 }\n");
  const auto engine = check_vectorised(text);
  CHECK(engine->out_channels() == 11);
}

TEST_CASE("side by side: lanes that answer one another within a frame stay on their own", "[runtime]") {
  // Lane 1 filters what lane 0 gives at once, and so on: side by side they would wait for themselves.
  std::string chain = "m = { type = \"low_pass\", cutoff = \"9 kHz\", in = [\"x\"", picks;
  for (int lane = 0; lane < 7; ++lane) {
    const auto name = std::to_string(lane);
    chain += ", \"p" + name + "\"";
    std::string only = "0, 0, 0, 0, 0, 0, 0, 0";
    only[static_cast<std::size_t>(3 * lane)] = '1';
    picks +=
        "o" + name + " = [" + only + "]\np" + name + " = { type = \"mix\", in = \"m * o" + name + "\" }\n";
  }
  const auto text = body(chain + "] }\n" + picks + "y = { type = \"mix\", in = \"m\" }\n");
  const auto engine = check_vectorised(text);
  CHECK(runs(*engine, "m[3]"));
  CHECK_FALSE(runs(*engine, "m[0..7]"));
}

TEST_CASE("side by side: a group that breaks is counted once and starts again as one", "[runtime]") {
  const auto engine = engine_of(body("d = { type = \"delay\", in = \"g\", voices = 8, time = \"1 / "
                                     "system.rate\", interpolation = \"none\" }\n"
                                     "g = \"1e200 * (x + d)\"\n"
                                     "m = { type = \"low_pass\", in = \"d\", cutoff = \"1 kHz\" }\n"
                                     "y = { type = \"mix\", in = \"m * 0\" }\n"
                                     "z = { type = \"mix\", in = \"m\" }\n") +
                                    "z = { from = \"z\" }\n",
                                true);
  const auto out = test::run(*engine, {test::noise(192, 1, 0.5, 1)}, 192, {64});
  const auto faults = engine->faults();
  REQUIRE(faults.size() == 1);
  // 1e200, then 1e400 overflows: once for all lanes in every cell of 64 frames, which is then silent.
  CHECK(faults[0].path == "g[0..7]");
  CHECK(faults[0].count == 3);
  for (const auto& channel : out)
    for (const auto sample : channel) CHECK(std::isfinite(sample));
}

TEST_CASE("side by side: channels that only lanes read are loaded as lanes", "[runtime]") {
  const auto wide = engine_of(eight_channels(), true);
  const auto alone = engine_of(eight_channels(), false);
  REQUIRE(wide->plan().input_lanes.size() == 1);
  CHECK(steps_of(wide->plan(), "pack") == 0);
  for (const std::size_t channels : {8u, 5u}) {
    INFO(channels << " channels of the card");
    auto noises = eight_noises();
    noises.resize(channels);
    const auto together = test::run(*wide, noises, kFrames, {64});
    CHECK(relative_difference(test::run(*alone, noises, kFrames, {64}), together) <= 1e-12);
    for (const std::vector<int>& blocks : {std::vector{1}, {17, 3, 64, 5}, {1024}})
      CHECK(test::first_difference(together, test::run(*wide, noises, kFrames, blocks)) == "");
  }
}

TEST_CASE("side by side: channels that something else reads as well are packed by a step", "[runtime]") {
  const auto text = eight_channels("z = { from = \"x\" }\n");
  const auto wide = engine_of(text, true);
  CHECK(wide->plan().input_lanes.empty());
  CHECK(steps_of(wide->plan(), "pack") == 1);
  auto expected = test::run(*engine_of(eight_channels(), true), eight_noises(), kFrames, {64});
  for (const auto& noise : eight_noises()) expected.push_back(noise);
  CHECK(test::first_difference(expected, test::run(*wide, eight_noises(), kFrames, {64})) == "");
}

TEST_CASE("side by side: what is not finite in a channel is 0 in its lane, and counted", "[runtime]") {
  auto noises = eight_noises();
  auto clean = noises;
  const double bad[] = {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e-310, -0.0};
  int frame = 100;
  for (const double sample : bad)
    for (const std::size_t channel : {2u, 7u}) {
      noises[channel][index(frame)] = sample;
      clean[channel][index(frame)] = 0;
      frame += 37;
    }
  const auto wide = engine_of(eight_channels(), true);
  for (const std::vector<int>& blocks : {std::vector{64}, {17, 3, 64, 5}}) {
    const auto expected = test::run(*wide, clean, kFrames, blocks);
    CHECK(wide->bad_input_samples() == 0);
    CHECK(test::first_difference(expected, test::run(*wide, noises, kFrames, blocks)) == "");
    CHECK(wide->bad_input_samples() == 6);
  }
}

TEST_CASE("side by side: the signal scope shows channels that are loaded as lanes", "[runtime]") {
  const auto engine = engine_of(eight_channels(), true);
  const auto noises = eight_noises();
  test::run(*engine, noises, 64, {64});
  int seen = 0;
  for (const auto& signal : scope_signals(engine->plan())) {
    if (!signal.name.starts_with("x[")) continue;
    const auto& channel = noises[index(signal.name[2] - '0')];
    for (int n = 0; n < 64; ++n) CHECK(signal.place.data[n * signal.place.stride] == channel[index(n)]);
    ++seen;
  }
  CHECK(seen == 8);
}

TEST_CASE("side by side: what answers within the frame is loaded as lanes", "[runtime]") {
  const std::string through =
      "format = 1\n[inputs]\nx = { lanes = 8 }\n[outputs]\ny = { from = \"-0.5 * x\" }\n";
  const std::string plant =
      "format = 1\n[inputs]\ndrive = { lanes = 8 }\n[nodes]\n"
      "start = { type = \"noise\", level = 1, voices = 8 }\n"
      "felt = { type = \"low_pass\", in = \"drive\", cutoff = \"2 kHz\" }\n"
      "last = { type = \"delay\", in = \"felt\", time = \"1 / system.rate\", interpolation = \"none\" }\n"
      "[outputs]\nsensor = { from = \"start + last\" }\n";
  const auto sensors = [&](bool vectorise) {
    CompileOptions options;
    options.closed_outside = true;
    options.vectorise = vectorise;
    const auto instrument = test::engine_of(through);
    const auto engine = test::engine_of(plant, options);
    CHECK(engine->plan().input_lanes.size() == (vectorise ? 1u : 0u));
    ClosedLoop loop{*instrument, *engine, 8, 0, {.on = false, .bits = 24}};
    REQUIRE(loop.prepare(48_kHz, 64));
    Channels played(8);
    loop.run(1000, [&](const ClosedLoop::Block& piece) {
      for (int c = 0; c < 8; ++c)
        played[index(c)].insert(played[index(c)].end(), piece.sensors[c], piece.sensors[c] + piece.frames);
    });
    return played;
  };
  CHECK(relative_difference(sensors(false), sensors(true)) <= 1e-12);
}
