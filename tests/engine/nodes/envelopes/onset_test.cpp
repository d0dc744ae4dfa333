#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/graphs/node_runner.h"

namespace tactus {
namespace {

constexpr int kFrames = 12000;

/// Three hits of 1 kHz, at frames 3000, 6000 and 9000.
test::Samples three_hits() {
  test::Samples in(kFrames, 0.0);
  for (int n = 3000; n < kFrames; ++n) {
    const double t = (n % 3000) / 48000.0;
    in[static_cast<std::size_t>(n)] = 0.25 * std::cos(6283.185307 * t) * std::exp(-t / 0.01);
  }
  return in;
}

}  // namespace

TEST_CASE("onset: a trigger of one frame for each hit", "[nodes]") {
  test::NodeRunner runner(test::node_type("onset"), {{"in", three_hits()}});
  const auto out = runner.run(test::even_cutting(kFrames, 64));
  for (int n = 0; n < kFrames; ++n)
    CHECK(out[0][static_cast<std::size_t>(n)] == (n >= 3000 && n % 3000 == 0 ? 1.0 : 0.0));
  // Held between hits: 0.25 less the 0.8 % of a high-pass at 30 Hz.
  CHECK(out[1][5999] == Approx(0.25).epsilon(0.01));
}

TEST_CASE("onset: the cutting into blocks changes no bit", "[nodes]") {
  test::NodeRunner runner(test::node_type("onset"), {{"in", test::noise(kFrames, 7)},
                                                     {"threshold", test::noise(kFrames, 8, 0.0, 0.5)},
                                                     {"hold", test::noise(kFrames, 9, 0.001, 0.02)}});
  CHECK(runner.cutting_matters(kFrames) == "");
  test::NodeRunner hits(test::node_type("onset"), {{"in", three_hits()}});
  CHECK(hits.cutting_matters(kFrames) == "");
}

}  // namespace tactus
