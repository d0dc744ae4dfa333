#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "engine/guard/guarded.h"
#include "engine/nodes/table.h"
#include "tests/conformance/node_cases.h"
#include "tests/conformance/random_graph.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/temporary_folder.h"

// Every loop of a random graph is bounded, and not one fault may be counted.

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr int kFrames = 1500;

/// Control `i` goes to some place of its range at some frame, six times.
std::vector<JournalEntry> random_moves(unsigned seed, std::size_t controls) {
  std::mt19937 bits(seed);
  std::vector<JournalEntry> moves;
  for (std::size_t m = 0; controls > 0 && m < 6; ++m)
    moves.push_back({.frame = static_cast<std::int64_t>(m * 200 + bits() % 200),
                     .kind = JournalEntry::Kind::ControlChange,
                     .index = static_cast<int>(bits() % controls),
                     .value = static_cast<double>(bits()) / 2147483648.0 - 1});
  return moves;
}

Channels run_guarded(Guarded& guarded, const Player& engine, const Channels& in) {
  Channels out(static_cast<std::size_t>(engine.out_channels()), Samples(kFrames));
  std::vector<const double*> from;
  std::vector<double*> to;
  for (const auto& channel : in) from.push_back(channel.data());
  for (auto& channel : out) to.push_back(channel.data());
  const StreamFormat format{engine.plan().sample_rate, 2, engine.out_channels(), kFrames};
  if (const auto ready = guarded.prepare(format); !ready) throw std::runtime_error(to_string(ready.error()));
  guarded.process({from.data(), to.data(), kFrames});
  return out;
}

/// "" or what went wrong with the graph of this seed.
std::string complaint(unsigned seed, const TemporaryFolder& folder) {
  const auto file = (folder.path() / "test.toml").string();
  const int lanes = 2 + static_cast<int>(seed % 3);
  folder.write("part.toml", RandomGraph{seed + 1000000, lanes}.text(true));
  const auto text = RandomGraph{seed, lanes}.text(false);
  auto compiled = compile(parse_graph_leniently(text, file), standard_nodes(), {});
  if (!compiled) return to_string(compiled.error()) + "\n" + text;
  Player engine{std::move(*compiled)};
  engine.set_journal(random_moves(seed, engine.plan().controls.size()));
  const Channels in{noise(kFrames, seed), noise(kFrames, seed + 1)};
  const auto out = run(engine, in, kFrames, {64});
  for (const auto& fault : engine.faults())
    return fault.path + " was not finite " + std::to_string(fault.count) + " times\n" + text;
  const auto difference = first_difference(out, run(engine, in, kFrames, {1, 37, 100, 3}));
  if (!difference.empty()) return difference + " by the size of the blocks\n" + text;
  Guarded guarded{engine, {}};
  for (const auto& channel : run_guarded(guarded, engine, in))
    for (const double sample : channel)
      if (!(std::abs(sample) <= DriveLimits{}.ceiling)) return "above the ceiling\n" + text;
  return {};
}

}  // namespace

TEST_CASE("random graphs: 300 compile, run without a fault, and give the same bits for any block",
          "[conformance]") {
  const TemporaryFolder folder;
  copy_files(folder);
  for (unsigned seed = 1; seed <= 300; ++seed) {
    INFO("seed " << seed);
    REQUIRE(complaint(seed, folder) == "");
  }
}

TEST_CASE("random graphs: so do 10000", "[.soak]") {
  const TemporaryFolder folder;
  copy_files(folder);
  for (unsigned seed = 1; seed <= 10000; ++seed) {
    INFO("seed " << seed);
    REQUIRE(complaint(seed, folder) == "");
  }
}
