#include "engine/runtime/signal_scope.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"
#include "tests/support/graphs/part_graph.h"

using namespace tactus;
using test::Samples;

namespace {

/// The outputs show what the scope is to show.
const std::string kGraph = R"([inputs]
x = {}
[controls]
gain = { value = 0.5, range = [0, 1], smooth = "5 ms" }
[nodes]
low   = { type = "one_pole", in = "x", cutoff = "500 Hz" }
twice = "2 * gain"
mixed = "low.low - twice * x"
line  = { type = "delay", in = "mixed + 0.5 * line", time = "7 / system.rate", interpolation = "none" }
many  = { type = "one_pole", in = "x", cutoff = { from = "100 Hz", to = "900 Hz" }, voices = 9 }
all   = { type = "mix", in = "many.low" }
part  = { use = "part.toml", x = "x", rate = "1/3" }
[outputs]
gain   = { from = "gain" }
low    = { from = "low.low" }
twice  = { from = "twice" }
mixed  = { from = "mixed" }
line   = { from = "line" }
fourth = { from = "many.low[3]" }
ninth  = { from = "many.low[8]" }
all    = { from = "all" }
part   = { from = "part" }
)";
const std::string kPart =
    "[inputs]\nx = {}\n[nodes]\nhalf = { type = \"one_pole\", in = \"0.5 * x\", cutoff = "
    "\"900 Hz\" }\n[outputs]\ny = { from = \"half.low\" }\n";

struct Recorded {
  std::int64_t first = 0;
  std::vector<Samples> traces;
  std::int64_t lost = 0;
};

/// What the scope showed, chunk after chunk without a gap. `blocks`: their lengths, over and over.
struct Run {
  std::map<std::string, Samples> outputs;
  Recorded scope;
};

struct Options {
  std::vector<std::string> names;
  std::vector<int> blocks = {64};
  int bin = 1;
  int frames = 4000;
  std::size_t chunks = 4096;
};

std::vector<SignalPlace> places_of(const Player& player, const std::vector<std::string>& names) {
  const auto signals = scope_signals(player.plan());
  std::vector<SignalPlace> places;
  for (const auto& name : names) {
    INFO(name);
    const auto found = std::ranges::find(signals, name, &ScopeSignal::name);
    REQUIRE(found != signals.end());
    places.push_back(found->place);
  }
  return places;
}

Recorded collect(SignalScope& scope) {
  Recorded all;
  std::int64_t next = -1;
  for (ScopeChunk chunk; scope.take(chunk);) {
    if (next < 0) {
      all.first = next = chunk.frame;
      all.traces.resize(static_cast<std::size_t>(chunk.traces));
    }
    REQUIRE(chunk.frame == next);
    next += std::int64_t{chunk.bins} * chunk.bin;
    for (int t = 0; t < chunk.traces; ++t)
      for (int v = 0; v < chunk.bins * chunk.per_bin(); ++v)
        all.traces[static_cast<std::size_t>(t)].push_back(
            double(chunk.values[static_cast<std::size_t>(t * ScopeChunk::kMostBins * chunk.per_bin() + v)]));
  }
  all.lost = scope.lost();
  return all;
}

Run run(const Options& options) {
  const test::PartGraphs graphs{kPart};
  const auto player = graphs.engine(kGraph);
  SignalScope scope{options.chunks};
  player->add_observer(scope);
  REQUIRE(
      scope.choose(ScopeChoice::of(player->version(), 7, options.bin, places_of(*player, options.names))));
  player->set_journal({{1001, JournalEntry::Kind::ControlChange, player->control_index("gain"), 0.9}});
  const auto outputs = test::run(*player, {test::noise(options.frames, 5)}, options.frames, options.blocks);
  Run ran{{}, collect(scope)};
  for (std::size_t c = 0; c < player->plan().channels.size(); ++c)
    ran.outputs[player->plan().channels[c].name] = outputs[c];
  return ran;
}

Samples rounded(const Samples& samples) {
  Samples floats;
  for (const double sample : samples) floats.push_back(double(static_cast<float>(sample)));
  return floats;
}

}  // namespace

TEST_CASE("signal scope: shows what the outputs are, frame for frame, whatever the blocks are") {
  const std::vector<int> blocks = GENERATE(std::vector{64}, std::vector{1}, std::vector{1000, 3, 77});
  const auto ran =
      run({.names = {"gain", "low.low", "twice", "mixed", "line", "many.low[3]", "many.low[8]", "out/all"},
           .blocks = blocks});
  const std::vector<std::string> names = {"gain", "low", "twice", "mixed", "line", "fourth", "ninth", "all"};
  REQUIRE(ran.scope.traces.size() == names.size());
  CHECK(ran.scope.first == 0);
  CHECK(ran.scope.lost == 0);
  for (std::size_t t = 0; t < names.size(); ++t) {
    INFO(names[t]);
    auto expected = rounded(ran.outputs.at(names[t]));
    CHECK(ran.scope.traces[t].size() >=
          expected.size() - ScopeChunk::kMostBins);  // the last chunk is not full
    expected.resize(ran.scope.traces[t].size());
    CHECK(test::first_difference({ran.scope.traces[t]}, {expected}).empty());
  }
}

TEST_CASE("signal scope: a bin has the lowest and the highest value of its frames") {
  constexpr int kBin = 100;
  const auto ran = run({.names = {"low.low"}, .blocks = {37}, .bin = kBin});
  const auto expected = rounded(ran.outputs.at("low"));
  const auto& shown = ran.scope.traces.at(0);
  REQUIRE(shown.size() >= 2 * 25);
  for (std::size_t bin = 0; bin < shown.size() / 2; ++bin) {
    const auto from = expected.begin() + static_cast<std::ptrdiff_t>(bin) * kBin;
    CHECK(shown[2 * bin] == *std::min_element(from, from + kBin));
    CHECK(shown[2 * bin + 1] == *std::max_element(from, from + kBin));
  }
}

TEST_CASE("signal scope: a signal of a part with a rate of its own stays between its samples") {
  const auto ran = run({.names = {"part.half.low"}, .blocks = {50}});
  const auto& shown = ran.scope.traces.at(0);
  REQUIRE(shown.size() > 3000);
  int changes = 0;
  for (std::size_t n = 1; n < shown.size(); ++n) {
    changes += shown[n] != shown[n - 1];
    if (n % 3 != 0) CHECK(shown[n] == shown[n - 1]);
  }
  CHECK(changes > 900);
}

TEST_CASE("signal scope: what finds no room is lost, and time goes on") {
  const auto ran = run({.names = {"low.low"}, .chunks = 4});
  CHECK(ran.scope.lost == 4000 / ScopeChunk::kMostBins - 4);
  CHECK(ran.scope.traces.at(0).size() == 4 * ScopeChunk::kMostBins);
}

TEST_CASE("signal scope: a choice holds for its version of the graph only, and the last one counts") {
  const auto text = [](const char* gain) {
    return std::string{"format = 1\n[inputs]\nx = {}\n[nodes]\ny = \"x * "} + gain +
           "\"\n[outputs]\ny = { from = \"y\" }\n";
  };
  const auto player = test::engine_of(text("2"));
  SignalScope scope, levels;
  player->add_observer(scope);
  player->add_observer(levels);
  const auto choose = [&](std::uint32_t id) {
    REQUIRE(scope.choose(ScopeChoice::of(player->version(), id, 1, places_of(*player, {"out/y"}))));
  };
  choose(1);
  choose(2);
  StreamFormat format{48_kHz, 1, 1, 64};
  REQUIRE(player->prepare(format));
  const Samples x(64, 0.25);
  Samples y(64);
  const double* in = x.data();
  double* out = y.data();
  const auto play_block = [&] { player->process({&in, &out, 64}); };
  ScopeChunk chunk;
  play_block();
  REQUIRE(scope.take(chunk));
  CHECK(chunk.id == 2);
  CHECK(chunk.values[0] == 0.5F);

  REQUIRE(player->replace(*compile(parse_graph_leniently(text("3"), "test.toml"), standard_nodes(), {})));
  play_block();
  CHECK_FALSE(scope.take(chunk));
  choose(3);
  play_block();
  REQUIRE(scope.take(chunk));
  CHECK(chunk.id == 3);
  CHECK(chunk.frame == 128);
  CHECK_FALSE(levels.take(chunk));
}

TEST_CASE("signal scope: an output that rests is read as one that may move again") {
  const auto player = test::engine_of(
      "format = 1\n[controls]\ngain = { value = 0.5, range = [0, 1] }\n[outputs]\ny = { from = \"2 * gain\" "
      "}\n");
  REQUIRE(player->prepare({48_kHz, 0, 1, 64}));
  Samples y(64);
  double* out = y.data();
  for (int block = 0; block < 10; ++block) player->process({nullptr, &out, 64});
  CHECK(y.back() == 1.0);
  const auto signals = scope_signals(player->plan());
  const auto found = std::ranges::find(signals, "out/y", &ScopeSignal::name);
  REQUIRE(found != signals.end());
  CHECK(found->place.stride == 1);
  CHECK(found->place.can_rest >= 0);
}
