
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/graphs/play_node.h"

using namespace tactus;
using test::play_node;
using test::Samples;

TEST_CASE("envelope: 63 % after its attack, 37 % after its release", "[nodes]") {
  Samples in(4800, 0.0);
  for (std::size_t n = 0; n < 2400; ++n) in[n] = -1;
  const auto out =
      play_node(test::node_type("envelope"), 4800, {{"in", in}, {"attack", 0.001}, {"release", 0.01}});
  CHECK(out[47] == Approx(1 - std::exp(-1.0)).epsilon(1e-12));
  CHECK(out[2399 + 480] == Approx(std::exp(-1.0)).epsilon(1e-12));
}

TEST_CASE("envelope: times of zero follow at once", "[nodes]") {
  const auto out = play_node(test::node_type("envelope"), 4,
                             {{"in", Samples{0, -2, 1, 0}}, {"attack", 0.0}, {"release", 0.0}});
  CHECK(out == Samples{0, 2, 1, 0});
}

TEST_CASE("decay: jumps to the level of its trigger and falls to e^(-t / time)", "[nodes]") {
  Samples trigger(2000, 0.0), level(2000, 9.0);
  trigger[100] = trigger[1500] = 1;
  level[100] = 2;
  level[1500] = 0.5;
  const auto out =
      play_node(test::node_type("decay"), 2000, {{"trigger", trigger}, {"level", level}, {"time", 0.01}});
  CHECK(out[99] == 0);
  CHECK(out[100] == 2);
  CHECK(out[100 + 1200] == Approx(2 * std::exp(-2.5)).epsilon(1200 * 2.3e-16));
  CHECK(out[1500] == 0.5);
}

TEST_CASE("decay: ends after its length", "[nodes]") {
  const auto out =
      play_node(test::node_type("decay"), 60, {{"trigger", 1.0}, {"time", 1.0}, {"length", 0.001}});
  CHECK(out[47] > 0.99);
  CHECK(out[48] == 0);
}

TEST_CASE("adsr: reaches 1 after its attack and its sustain after the decay", "[nodes]") {
  Samples gate(9600, 1.0);
  for (std::size_t n = 4800; n < 9600; ++n) gate[n] = 0;
  const auto out =
      play_node(test::node_type("adsr"), 9600,
                {{"gate", gate}, {"attack", 0.001}, {"decay", 0.005}, {"sustain", 0.5}, {"release", 0.01}});
  CHECK(out[23] == Approx(0.5).epsilon(1e-14));
  CHECK(out[47] == Approx(1).epsilon(1e-14));
  CHECK(out[48 + 240] ==
        Approx(0.5 + 0.5 * std::exp(-1.0)).epsilon(0.005));  // 1 is reached in frame 47 or 48
  CHECK(out[4799] == Approx(0.5).epsilon(1e-8));
  CHECK(out[4799 + 480] == Approx(0.5 * std::exp(-1.0)).epsilon(1e-8));
}
