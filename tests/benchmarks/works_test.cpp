#include "tests/benchmarks/works.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "tests/benchmarks/exported_program.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/skip.h"

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

void check_same(const Channels& one, const Channels& other) {
  REQUIRE(one.size() == other.size());
  double peak = 0, difference = 0;
  for (std::size_t c = 0; c < other.size(); ++c)
    for (std::size_t n = 0; n < other[c].size(); ++n) {
      peak = std::max(peak, std::abs(other[c][n]));
      difference = std::max(difference, std::abs(one[c][n] - other[c][n]));
    }
  CHECK(peak > 1e-3);
  CHECK(difference < 1e-9 * peak);
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
    check_same(graph, plain);
  }
}

// As above: frame by frame, the exported sums have the order of their equations.
TEST_CASE("benchmarks: an exported program and the plain loop beside it give the same signal",
          "[benchmarks][export]") {
  constexpr int kFrames = 9000;
  if (std::system(TACTUS_C_COMPILER " --version > /dev/null 2>&1") != 0) test::skip("there is no C compiler");
  for (const auto& work : works()) {
    CAPTURE(work.name);
    ExportedProgram program{parse_graph_leniently(text_of(work), work.name)};
    const auto in = excitation(work, kFrames);
    const auto plain = hand_written(work, in, kFrames);
    auto exported = plain;
    std::vector<const double*> from;
    std::vector<double*> to;
    for (const auto& channel : in) from.push_back(channel.data());
    for (auto& channel : exported) to.push_back(channel.data());
    program.start();
    program.process(from.data(), to.data(), kFrames);
    check_same(exported, plain);
  }
}

}  // namespace
}  // namespace tactus::bench
