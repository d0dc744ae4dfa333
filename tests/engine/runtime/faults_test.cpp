#include <catch2/catch.hpp>
#include <limits>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"
#include "tests/support/parse_graph.h"

using namespace tactus;
using tactus::test::parse_graph;

namespace {

/// out = in + 0.5 * out1, but what `poison` says as long as `poison` is not zero.
class Fragile : public Node {
 public:
  void process(const NodeBlock& block) noexcept override {
    for (int n = 0; n < block.frames; ++n) {
      last_ = block.in[0][n] + 0.5 * last_;
      if (block.in[1][n] > 0) last_ = std::numeric_limits<double>::quiet_NaN();
      if (block.in[1][n] < 0) last_ = std::numeric_limits<double>::infinity();
      block.out[0][n] = last_;
    }
  }
  void reset() noexcept override { last_ = 0; }

 private:
  double last_ = 0;
};

const NodeType& fragile_type() {
  static const NodeType type = {
      .name = "fragile",
      .group = "tests",
      .summary = "Breaks on request.",
      .equation = "",
      .source = "",
      .example = "",
      .inputs = {{.name = "in", .unit = "any", .doc = "", .fallback = {}},
                 {.name = "poison", .unit = "any", .doc = "", .fallback = {}}},
      .outputs = {{.name = "out", .unit = "=in", .doc = "", .range = {}}},
      .settings = {},
      .make = [](const NodeSetup&) -> Result<std::unique_ptr<Node>> { return std::make_unique<Fragile>(); },
      .range = {}};
  return type;
}

std::unique_ptr<Player> engine_of(const std::string& body) {
  auto table = standard_nodes();
  table.types.push_back(&fragile_type());
  const auto spec =
      parse_graph("format = 1\nname = \"test\"\n[inputs]\nx = {}\npoison = {}\n" + body, "test.toml");
  if (!spec) throw std::runtime_error(to_string(spec.error()));
  auto compiled = compile(**spec, table, {});
  if (!compiled) throw std::runtime_error(to_string(compiled.error()));
  return std::make_unique<Player>(std::move(*compiled));
}

/// "path: count, ..."
std::string faults_of(const Player& engine) {
  std::string text;
  for (const auto& fault : engine.faults()) text += fault.path + ": " + std::to_string(fault.count) + "; ";
  return text;
}

test::Samples poison_at(int frames, int frame, double value) {
  test::Samples samples(static_cast<std::size_t>(frames));
  samples[static_cast<std::size_t>(frame)] = value;
  return samples;
}

bool all_zero(const test::Samples& samples, int from, int to) {
  return std::all_of(samples.begin() + from, samples.begin() + to, [](double s) { return s == 0; });
}

const std::string kBesides = R"(
other = { type = "delay", in = "x + 0.6 * other", time = "11 / system.rate" }
clean = "x * 0.5"
[outputs]
y     = { from = "y" }
other = { from = "other" }
clean = { from = "clean" }
)";

}  // namespace

TEST_CASE("Player: a node that breaks is counted, silent and starts again, the rest sounds on", "[runtime]") {
  const auto engine = engine_of(
      "[nodes]\nbad = { type = \"fragile\", in = \"x\", poison = \"poison\" }\n"
      "y = \"bad + 1\"\n" +
      kBesides);
  const auto x = test::noise(640, 1);
  const auto sound = test::run(*engine, {x, test::Samples(640)}, 640, {64});
  for (const double poison : {1.0, -1.0}) {
    const auto out = test::run(*engine, {x, poison_at(640, 200, poison)}, 640, {64});
    CHECK(faults_of(*engine) == "bad: 1; ");
    CHECK(test::first_difference({sound[1], sound[2]}, {out[1], out[2]}) == "");
    // From the bad frame to the end of its cell of 64 the node gives 0, and starts from rest behind.
    CHECK(std::all_of(out[0].begin() + 200, out[0].begin() + 256, [](double s) { return s == 1; }));
    CHECK(test::first_difference({{sound[0].begin(), sound[0].begin() + 200}},
                                 {{out[0].begin(), out[0].begin() + 200}}) == "");
    CHECK(out[0][256] == x[256] + 1);
    // 0.5^60 of the state is below the last bit.
    CHECK(test::first_difference({{sound[0].begin() + 320, sound[0].end()}},
                                 {{out[0].begin() + 320, out[0].end()}}) == "");
  }
}

TEST_CASE("Player: a loop that breaks is reset as a whole and silent to the end of its 64 frames",
          "[runtime]") {
  const auto engine = engine_of(
      "[nodes]\nbad = { type = \"fragile\", in = \"x + 0.5 * line\", poison = \"poison\" }\n"
      "line = { type = \"delay\", in = \"y\", time = \"20 / system.rate\", interpolation = \"none\" }\n"
      "y = \"0.9 * bad\"\n" +
      kBesides);
  REQUIRE(engine->plan().loops.size() == 2);
  const auto x = test::noise(1280, 1);
  const auto sound = test::run(*engine, {x, test::Samples(1280)}, 1280, {64});
  const auto out = test::run(*engine, {x, poison_at(1280, 200, 1)}, 1280, {64});
  CHECK(faults_of(*engine) == "bad: 1; ");
  CHECK(test::first_difference({sound[1], sound[2]}, {out[1], out[2]}) == "");
  CHECK(all_zero(out[0], 200, 256));
  CHECK(out[0][256] == 0.9 * x[256]);
  CHECK(test::first_difference({{sound[0].begin(), sound[0].begin() + 200}},
                               {{out[0].begin(), out[0].begin() + 200}}) == "");
  // Behind it the loop sounds as one that starts at frame 256.
  auto later = test::Samples(x.begin() + 256, x.end());
  const auto fresh = test::run(*engine, {later, test::Samples(later.size())}, 1280 - 256, {64});
  CHECK(test::first_difference({fresh[0]}, {{out[0].begin() + 256, out[0].end()}}) == "");
}

TEST_CASE("Player: what a fault silences does not depend on the blocks", "[runtime]") {
  const auto straight = engine_of(
      "[nodes]\nbad = { type = \"fragile\", in = \"x\", poison = \"poison\" }\ny = \"bad + 1\"\n" + kBesides);
  // The line stands before what breaks, and a second thing breaks a frame earlier in the second half.
  const auto loop = engine_of(
      "[nodes]\nline = { type = \"delay\", in = \"later\", time = \"20 / system.rate\", interpolation = "
      "\"none\" "
      "}\n"
      "bad = { type = \"fragile\", in = \"x + 0.5 * line\", poison = \"max(0, poison)\" }\n"
      "later = { type = \"fragile\", in = \"0.9 * bad\", poison = \"min(0, poison)\" }\n"
      "y = \"bad\"\n" +
      kBesides);
  const auto x = test::noise(2000, 1);
  auto poison = poison_at(2000, 200, 1);
  poison[501] = 1;
  poison[500] = -1;
  poison[1000] = -1;
  poison[1023] = 1;
  poison[1024] = 1;
  for (const auto* engine : {&straight, &loop}) {
    const auto expected = test::run(**engine, {x, poison}, 2000, {64});
    const auto faults = faults_of(**engine);
    CHECK(faults == (engine == &loop ? "bad: 2; later: 2; " : "bad: 4; "));
    for (const auto& blocks : std::vector<std::vector<int>>{{1}, {7}, {48}, {100}, {1, 63, 5, 200}}) {
      INFO("blocks of " << blocks[0]);
      CHECK(test::first_difference(expected, test::run(**engine, {x, poison}, 2000, blocks)) == "");
      CHECK(faults_of(**engine) == faults);
    }
  }
}

TEST_CASE("Player: a loop that grows beyond all bounds is counted under the first bad step", "[runtime]") {
  const auto engine = engine_of(
      "[nodes]\nline = { type = \"delay\", in = \"grown\", time = \"1 / system.rate\", interpolation = "
      "\"none\" }\n"
      "sum = \"x + line\"\ngrown = \"1e200 * sum\"\ny = \"line\"\n" +
      kBesides);
  const auto x = test::noise(64, 1, 0.5, 1);
  const auto out = test::run(*engine, {x, test::Samples(64)}, 64, {64});
  // 1e200, then 1e400 overflows; silence to the end of the 64 frames.
  CHECK(faults_of(*engine) == "grown: 1; ");
  for (const auto sample : out[0]) CHECK(std::isfinite(sample));
}

TEST_CASE("Player: an operator that overflows loses its bad frames only, under its own name", "[runtime]") {
  const auto engine =
      engine_of("[nodes]\nfine = \"2 * x\"\nhuge = \"1e300 * poison\"\ny = \"fine + huge\"\n" + kBesides);
  const auto x = test::noise(100, 1);
  for (const int block : {1, 100}) {
    const auto out = test::run(*engine, {x, poison_at(100, 50, 1e30)}, 100, {block});
    CHECK(faults_of(*engine) == "huge: 1; ");
    for (std::size_t n = 0; n < x.size(); ++n) CHECK(out[0][n] == 2 * x[n]);
  }
}

TEST_CASE("Player: what is not finite at an input is counted and read as zero", "[runtime]") {
  const auto engine = engine_of("[nodes]\ny = \"x\"\n" + kBesides);
  auto x = test::noise(300, 1);
  auto repaired = x;
  for (const std::size_t frame : {0u, 65u, 299u}) {
    x[frame] =
        frame == 65 ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
    repaired[frame] = 0;
  }
  const auto expected = test::run(*engine, {repaired, test::Samples(300)}, 300, {77});
  CHECK(engine->bad_input_samples() == 0);
  const auto out = test::run(*engine, {x, test::Samples(300)}, 300, {77});
  CHECK(engine->bad_input_samples() == 3);
  CHECK(engine->faults().empty());
  CHECK(test::first_difference(expected, out) == "");
}
