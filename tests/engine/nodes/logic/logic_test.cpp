
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/graphs/play_node.h"

using namespace tactus;
using test::play_node;
using test::refusal;
using test::Samples;

TEST_CASE("threshold: fires for one frame, and its gate stays up until the hysteresis is passed", "[nodes]") {
  test::NodeRunner runner(test::node_type("threshold"),
                          {{"in", Samples{0, 1, 2, 0.9, 0.7, 1, 0}}, {"level", 1.0}, {"hysteresis", 0.2}});
  const auto out = runner.run(test::even_cutting(7, 7));
  CHECK(out[0] == Samples{0, 1, 0, 0, 0, 1, 0});
  CHECK(out[1] == Samples{0, 1, 1, 1, 0, 1, 0});
}

TEST_CASE("threshold: does not trigger again within its hold, and then at once where it was reached",
          "[nodes]") {
  test::NodeRunner runner(test::node_type("threshold"), {{"in", Samples{0, 1, 0, 1, 1, 1, 1, 0, 1}},
                                                         {"level", 1.0},
                                                         {"hysteresis", 0.2},
                                                         {"hold", 5 / 48000.0}});
  const auto out = runner.run(test::even_cutting(9, 9));
  CHECK(out[0] == Samples{0, 1, 0, 0, 0, 0, 1, 0, 0});
  CHECK(out[1] == Samples{0, 1, 0, 1, 1, 1, 1, 0, 1});
}

TEST_CASE("sample_hold: takes over in the frame of the trigger", "[nodes]") {
  CHECK(play_node(test::node_type("sample_hold"), 5,
                  {{"in", Samples{1, 2, 3, 4, 5}}, {"trigger", Samples{0, 1, 1, 0, 1}}}) ==
        Samples{0, 2, 2, 2, 5});
}

TEST_CASE("latch: on at set, off at reset, which wins", "[nodes]") {
  CHECK(play_node(test::node_type("latch"), 6,
                  {{"set", Samples{0, 1, 0, 0, 1, 0}}, {"reset", Samples{0, 0, 0, 1, 0, 0}}}) ==
        Samples{0, 1, 1, 0, 1, 1});
  CHECK(play_node(test::node_type("latch"), 2, {{"set", 1.0}, {"reset", 1.0}}) == Samples{0, 0});
}

TEST_CASE("counter: modulo its count, from 0 after a reset", "[nodes]") {
  const Samples trigger = {0, 1, 0, 1, 0, 1, 0, 1, 0};
  const Samples reset = {0, 0, 0, 0, 1, 0, 0, 1, 0};
  CHECK(play_node(test::node_type("counter"), 9, {{"trigger", trigger}}) ==
        Samples{0, 1, 1, 2, 2, 3, 3, 4, 4});
  CHECK(play_node(test::node_type("counter"), 9, {{"trigger", trigger}, {"count", 3.0}}) ==
        Samples{0, 1, 1, 2, 2, 0, 0, 1, 1});
  CHECK(play_node(test::node_type("counter"), 9, {{"trigger", trigger}, {"reset", reset}}) ==
        Samples{0, 1, 1, 2, 0, 1, 1, 0, 0});
}

TEST_CASE("clip: keeps what is inside and limits what is not", "[nodes]") {
  const Samples in = {-3, -0.5, 0.5, 3};
  CHECK(play_node(test::node_type("clip"), 4, {{"in", in}}) == Samples{-1, -0.5, 0.5, 1});
  CHECK(play_node(test::node_type("clip"), 4, {{"in", in}, {"low", Samples{2, 2, 2, 2}}}) ==
        Samples{2, 2, 2, 2});
}

TEST_CASE("clip, map, curve: ranges that the compiler can rely on", "[nodes]") {
  NodeSetup clip = {.sample_rate = 48_kHz, .type = &test::node_type("clip"), .inputs = {}, .settings = {}};
  for (const Interval range : {Interval{-3, 3}, Interval{-1, -1}, Interval{2, 2}})
    clip.inputs.push_back({range, std::nullopt, true});
  CHECK(test::node_type("clip").range(0, clip).low == -1);
  CHECK(test::node_type("clip").range(0, clip).high == 2);
  for (const NodeType* type : {&test::node_type("map"), &test::node_type("curve")}) {
    NodeSetup table = {.sample_rate = 48_kHz, .type = type, .inputs = {{}}, .settings = {}};
    table.inputs.resize(type->inputs.size(), {{1, 1}, 1.0});
    for (const auto& setting : type->settings)
      table.settings.push_back(test::setting_value(
          setting, setting.name == "points" ? "[[0, 110], [1, 440], [2, 220]]" : setting.fallback));
    CHECK(type->range(0, table).low == 110);
    CHECK(type->range(0, table).high == 440);
  }
}

TEST_CASE("map: linear and exponential between points, held outside", "[nodes]") {
  const Samples in = {-1, 0, 0.1, 0.2, 1};
  const std::string points = "[[0, 110], [0.2, 440]]";
  CHECK(play_node(test::node_type("map"), 5, {{"in", in}}, {{"points", points}}) ==
        Samples{110, 110, 275, 440, 440});
  CHECK(play_node(test::node_type("map"), 5, {{"in", in}},
                  {{"points", points}, {"curve", "exponential"}})[2] == Approx(220).epsilon(1e-14));
}

TEST_CASE("map: points that are no curve are refused with the reason", "[nodes]") {
  CHECK(refusal(test::node_type("map"), {{"in", 0.0}},
                {{"points", "[[0, -1], [1, 1]]"}, {"curve", "exponential"}}) == "BadArgument 'points'");
}

TEST_CASE("quantiser: nearest and floor", "[nodes]") {
  const Samples in = {-0.6, 0.2, 0.3, 0.9};
  CHECK(play_node(test::node_type("quantiser"), 4, {{"in", in}, {"step", 0.5}}) == Samples{-0.5, 0, 0.5, 1});
  CHECK(play_node(test::node_type("quantiser"), 4, {{"in", in}, {"step", 0.5}}, {{"rounding", "floor"}}) ==
        Samples{-1, 0, 0, 0.5});
}

TEST_CASE("mix: passes a single lane on", "[nodes]") {
  CHECK(play_node(test::node_type("mix"), 3, {{"in", Samples{1, -2, 3}}}) == Samples{1, -2, 3});
}

TEST_CASE("interval: in the frame of a trigger it is the time since the one before", "[nodes]") {
  const auto out = play_node(test::node_type("interval"), 8,
                             {{"trigger", Samples{0, 0, 1, 0, 0, 1, 1, 0}}, {"initial", 1.0}});
  Samples frames;
  for (const double seconds : out) frames.push_back(std::round(seconds * 48000 * 1e6) / 1e6);
  CHECK(frames == Samples{48000, 48001, 48002, 1, 2, 3, 1, 2});
}

TEST_CASE("state: takes over its input in the frame after a trigger, and is the initial value before",
          "[nodes]") {
  CHECK(play_node(
            test::node_type("state"), 6,
            {{"in", Samples{1, 2, 3, 4, 5, 6}}, {"trigger", Samples{0, 1, 0, 0, 1, 0}}, {"initial", 9.0}}) ==
        Samples{9, 9, 2, 2, 2, 5});
}
