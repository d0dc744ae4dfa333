#include <catch2/catch.hpp>

#include "tests/support/graphs/play_node.h"

using namespace tactus;
using test::play_node;
using test::Samples;

TEST_CASE("slew: a step becomes a straight line of the given rate, up and down", "[nodes]") {
  // 48 frames a millisecond: 12000 a second are 0.25 a frame, 24000 are 0.5.
  CHECK(play_node(test::node_type("slew"), 8,
                  {{"in", Samples{1, 1, 1, 1, 1, 0, 0, 0}}, {"rise", 12000.0}, {"fall", 24000.0}}) ==
        Samples{0.25, 0.5, 0.75, 1, 1, 0.5, 0, 0});
}

TEST_CASE("slew: what is slow enough passes unchanged", "[nodes]") {
  const Samples in = {0.1, 0.2, 0.1, -0.1};
  CHECK(play_node(test::node_type("slew"), 4, {{"in", in}, {"rise", 12000.0}, {"fall", 12000.0}}) == in);
}
