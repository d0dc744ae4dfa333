#include <catch2/catch.hpp>
#include <cmath>

#include "engine/dsp/envelopes/stroke_kernel.h"
#include "tests/support/graphs/node_runner.h"

namespace tactus {
namespace {

constexpr int kFrames = 24000;

/// Three strokes of 1 kHz, at frames 9600, 14400 and 19200.
test::Samples three_strokes() {
  test::Samples in = test::noise(kFrames, 3, -1e-4, 1e-4);
  for (int n = 9600; n < kFrames; ++n) {
    const double t = (n % 4800) / 48000.0;
    in[static_cast<std::size_t>(n)] += 0.25 * std::cos(6283.185307 * t) * std::exp(-t / 0.01);
  }
  return in;
}

}  // namespace

TEST_CASE("stroke: a trigger of one frame for each stroke, and its level", "[nodes]") {
  test::NodeRunner runner(test::node_type("stroke"), {{"in", three_strokes()}});
  const auto out = runner.run(test::even_cutting(kFrames, 64));
  int hits = 0;
  for (int n = 0; n < kFrames; ++n) {
    if (out[0][static_cast<std::size_t>(n)] == 0) continue;
    ++hits;
    CHECK(n % 4800 < 48 * 2);  // 2 ms
    CHECK(n % 24 == 23);       // at the end of a frame of 0.5 ms
  }
  CHECK(hits == 3);
  CHECK(out[1][static_cast<std::size_t>(kFrames - 1)] == Approx(0.25).epsilon(0.01));
}

TEST_CASE("stroke: the cutting into blocks changes no bit", "[nodes]") {
  test::NodeRunner noise(test::node_type("stroke"), {{"in", test::noise(kFrames, 7)},
                                                     {"reference", test::noise(kFrames, 8)},
                                                     {"hold", test::noise(kFrames, 9, 0.001, 0.02)}});
  CHECK(noise.cutting_matters(kFrames) == "");
  test::NodeRunner strokes(test::node_type("stroke"), {{"in", three_strokes()}});
  CHECK(strokes.cutting_matters(kFrames) == "");
}

}  // namespace tactus
