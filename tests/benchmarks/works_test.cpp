#include "tests/benchmarks/works.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "tests/support/graphs/graph_runner.h"

namespace tactus::bench {
namespace {

std::string text_of(const Work& work) {
  if (work.graph.empty()) return work.text;
  std::ifstream file(std::string(TACTUS_SOURCE_DIR "/tests/benchmarks/graphs/") + work.graph);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

Channels hand_written(const Work& work, const Channels& in, int frames) {
  Channels out(static_cast<std::size_t>(work.outputs), std::vector<double>(static_cast<std::size_t>(frames)));
  std::vector<const double*> from;
  std::vector<double*> to;
  for (const auto& channel : in) from.push_back(channel.data());
  for (auto& channel : out) to.push_back(channel.data());
  make_hand_written<double>(work)->process(from.data(), to.data(), frames);
  return out;
}

// Both compute the same sums of products in another order. A sum is a few terms long and each loop forgets
// within some thousand frames, so that rounding (1.1e-16 of the peak) stays far below 1e-9 of it; a wrong
// coefficient or a delay off by one would show at 1e-3.
TEST_CASE("benchmarks: a graph and the plain loop beside it give the same signal", "[benchmarks]") {
  constexpr int kFrames = 9000;
  for (const auto& work : works()) {
    CAPTURE(work.name);
    const auto in = excitation(work, kFrames);
    const auto engine = test::engine_of(text_of(work));
    const auto graph = test::run(*engine, in, kFrames, {64, 1, 250});
    const auto plain = hand_written(work, in, kFrames);
    REQUIRE(graph.size() == plain.size());
    double peak = 0, difference = 0;
    for (std::size_t c = 0; c < plain.size(); ++c)
      for (std::size_t n = 0; n < plain[c].size(); ++n) {
        peak = std::max(peak, std::abs(plain[c][n]));
        difference = std::max(difference, std::abs(graph[c][n] - plain[c][n]));
      }
    CHECK(peak > 1e-3);
    CHECK(difference < 1e-9 * peak);
  }
}

}  // namespace
}  // namespace tactus::bench
