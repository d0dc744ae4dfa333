#include <catch2/catch.hpp>

#include "tests/support/graphs/play_node.h"

using namespace tactus;
using test::play_node;
using test::Samples;

namespace {

/// From 0 up to 1, then between 1 and -1, in steps of 1/64: every number is exact.
Samples triangle(int periods) {
  Samples x;
  for (int n = 0; n <= 256 * periods + 64; ++n) {
    const int phase = (n + 64) % 256;  // 0: at -1, 128: at 1
    x.push_back(phase <= 128 ? phase / 64.0 - 1 : 3 - phase / 64.0);
  }
  return x;
}

}  // namespace

TEST_CASE("hysteresis: moves only when an end of the width pushes it", "[nodes]") {
  CHECK(play_node(test::node_type("hysteresis"), 7,
                  {{"in", Samples{0.1, 1, 2, 1.5, 1, 0, -1}}, {"width", 1.0}}) ==
        Samples{0, 0.5, 1.5, 1.5, 1.5, 0.5, -0.5});
}

TEST_CASE("hysteresis: movements smaller than the width are not passed on", "[nodes]") {
  const Samples in = {0.2, -0.2, 0.24, -0.25, 0.25};
  CHECK(play_node(test::node_type("hysteresis"), 5, {{"in", in}, {"width", 0.5}}) == Samples(5, 0.0));
}

TEST_CASE("hysteresis: without a width it passes its input", "[nodes]") {
  const Samples in = {0.2, -0.7, 3};
  CHECK(play_node(test::node_type("hysteresis"), 3, {{"in", in}, {"width", 0.0}}) == in);
}

TEST_CASE("hysteresis: a cycle of amplitude A encloses width (2 A - width)", "[nodes]") {
  // Output against input is a parallelogram: `width` wide, and 2 (A - width / 2) high.
  const double width = GENERATE(0.25, 0.5, 1.5);
  const auto x = triangle(2);
  const auto y =
      play_node(test::node_type("hysteresis"), static_cast<int>(x.size()), {{"in", x}, {"width", width}});
  double area = 0;
  for (std::size_t n = x.size() - 256; n < x.size(); ++n) area += 0.5 * (x[n] + x[n - 1]) * (y[n] - y[n - 1]);
  CHECK(area == width * (2 - width));
}
