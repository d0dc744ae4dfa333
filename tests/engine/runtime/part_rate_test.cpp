#include <catch2/catch.hpp>
#include <numbers>
#include <numeric>

#include "tests/support/graphs/node_runner.h"
#include "tests/support/graphs/part_graph.h"

using namespace tactus;
using test::Channels;
using test::PartGraphs;
using test::Samples;

namespace {

const std::string kPlain = "[inputs]\nx = {}\n[outputs]\ny = { from = \"2 * x\" }\n";

/// One part of the input x at a rate of its own; `words` say which.
std::string user(const std::string& words) {
  return "[inputs]\nx = {}\n[nodes]\npart = { use = \"part.toml\", x = \"x\", " + words +
         " }\n[outputs]\ny = { from = \"part\" }\n";
}

Samples play(const PartGraphs& graphs, const std::string& text, const Samples& x, int block = 64) {
  const auto engine = graphs.engine(text);
  return test::run(*engine, {x}, static_cast<int>(x.size()), {block})[0];
}

/// 0, 1, 2, ...
Samples ramp(int frames) {
  Samples x(static_cast<std::size_t>(frames));
  for (int n = 0; n < frames; ++n) x[static_cast<std::size_t>(n)] = n;
  return x;
}

/// Everything that can stand in a part: filters, a loop, a network, events, voices, a part of its own.
const std::string kRich = R"([inputs]
x  = {}
go = {}
[controls]
gain = { value = 0.4, range = [-1, 1] }
[nodes]
low   = { type = "low_pass", in = "x", cutoff = "600 Hz" }
line  = { type = "delay", in = "gain * low + 0.5 * line", time = "3 / system.rate", interpolation = "none" }
near  = { type = "delay", in = "low - 0.6 * near", time = "1 / system.rate", interpolation = "none" }
count = { type = "counter", trigger = "go", count = 5 }
many  = { type = "one_pole", in = "x", cutoff = { from = "100 Hz", to = "900 Hz" }, voices = 9 }
all   = { type = "mix", in = "many" }
inner = { use = "inner.toml", x = "low", rate = "1/3", between = "line" }
hit   = { type = "threshold", in = "x", level = 0.7 }
[networks.coil]
frame = { type = "ground" }
cone  = { type = "mass", mass = "35 g" }
hold  = { type = "spring", between = ["frame", "cone"], stiffness = "1000 N/m", damping = "1.2 kg/s" }
push  = { type = "force", on = "cone", force = "2 N * x - 9 N s/m * coil.cone.velocity" }
[outputs]
y    = { from = "line + near + count + 0.1 * all + inner" }
cone = { from = "coil.cone.position", unit = "m" }
hit  = { from = "hit" }
)";
const std::string kInner = R"([inputs]
x = {}
[nodes]
echo = { type = "delay", in = "x + 0.3 * echo", time = "5 / system.rate" }
[outputs]
y = { from = "echo + 0.1 * x" }
)";

/// That part in a loop of one frame of its user, and once more beside it.
std::string rich_user(const std::string& words) {
  return R"graph([inputs]
x  = {}
go = {}
[controls]
level = { value = 0.3, range = [0, 1], smooth = "5 ms" }
[nodes]
part  = { use = "part.toml", x = "x + 0.2 * back", go = "go", gain = "level", )graph" +
         words + R"graph( }
back  = { type = "delay", in = "max(-1, min(1, part.y))", time = "1 / system.rate", interpolation = "none" }
again = { use = "part.toml", x = "x", go = "part.hit", gain = -0.5, rate = "1/100", take = "mean" }
[outputs]
y    = { from = "part.y" }
cone = { from = "part.cone", unit = "m" }
z    = { from = "again.y" }
back = { from = "back" }
)graph";
}

struct RichGraphs : PartGraphs {
  RichGraphs() : PartGraphs{kRich} { write("inner.toml", kInner); }
};

Channels excitation(int frames) {
  Samples go(static_cast<std::size_t>(frames));
  for (int n = 31; n < frames; n += 177) go[static_cast<std::size_t>(n)] = 1;
  return {test::noise(frames, 3), go};
}

/// Counts the frames that it is given.
class Meter : public Node {
 public:
  static inline int frames = 0;
  void process(const NodeBlock& block) noexcept override {
    frames += block.frames;
    for (int n = 0; n < block.frames; ++n) block.out[0][n] = block.in[0][n];
  }
  void reset() noexcept override {}
};

const NodeType& meter_type() {
  static const NodeType type = {
      .name = "meter",
      .group = "tests",
      .summary = "Counts frames.",
      .equation = "",
      .source = "",
      .example = "",
      .inputs = {{.name = "in", .unit = "any", .doc = "", .fallback = {}}},
      .outputs = {{.name = "out", .unit = "=in", .doc = "", .range = {}}},
      .settings = {},
      .make = [](const NodeSetup&) -> Result<std::unique_ptr<Node>> { return std::make_unique<Meter>(); },
      .range = {}};
  return type;
}

}  // namespace

TEST_CASE("part rate: every fourth sample goes in, and what comes out is held", "[runtime]") {
  const PartGraphs graphs{kPlain};
  const auto x = test::noise(400, 1);
  const auto y = play(graphs, user("rate = \"1/4\""), x);
  for (std::size_t n = 0; n < x.size(); ++n) CHECK(y[n] == 2 * x[n - n % 4]);
  CHECK(play(graphs, user("rate = \"12 kHz\""), x) == y);
  CHECK(play(graphs, user("rate = \"1/1\""), x) == play(graphs, user("about = \"\""), x));
}

TEST_CASE("part rate: a mean is late by half of what it is taken over, a line by one frame of the part",
          "[runtime]") {
  const PartGraphs graphs{kPlain};
  const auto x = ramp(200);
  const auto mean = play(graphs, user("rate = \"1/8\", take = \"mean\""), x);
  const auto line = play(graphs, user("rate = \"1/8\", between = \"line\""), x);
  for (int n = 16; n < 200; ++n) {
    CHECK(mean[static_cast<std::size_t>(n)] == 2 * (n - n % 8 - 3.5));
    CHECK(line[static_cast<std::size_t>(n)] == 2 * (n - 8));
  }
}

TEST_CASE("part rate: a trigger between two frames of the part counts, once, and fires for one frame outside",
          "[runtime]") {
  const PartGraphs graphs{R"([inputs]
go = {}
[nodes]
count = { type = "counter", trigger = "go", count = 100 }
every = { type = "threshold", in = "count", level = 0.5 }
[outputs]
count = { from = "count" }
fired = { from = "every" }
)"};
  const auto engine = graphs.engine(R"([inputs]
x = {}
[nodes]
hit  = { type = "threshold", in = "x", level = 0.5 }
part = { use = "part.toml", go = "hit", rate = "1/16" }
[outputs]
count = { from = "part.count" }
fired = { from = "part.fired" }
)");
  Samples x(400);
  for (const std::size_t n : {5u, 100u, 133u, 175u}) x[n] = 1;
  const auto out = test::run(*engine, {x}, 400, {64});
  // Frames 16, 112, 144 and 176 of the part's grid see them.
  CHECK(out[0][15] == 0);
  CHECK(out[0][16] == 1);
  CHECK(out[0][399] == 4);
  CHECK(std::accumulate(out[1].begin(), out[1].end(), 0.0) == 1);
  CHECK(out[1][16] == 1);
}

TEST_CASE("part rate: inside, times and frequencies are those of the world, and frames are its own",
          "[runtime]") {
  const PartGraphs graphs{R"([inputs]
x = {}
[nodes]
low  = { type = "one_pole", in = "x", cutoff = "100 Hz" }
late = { type = "delay", in = "x", time = "1 / system.rate", interpolation = "none" }
[outputs]
low  = { from = "low.low" }
late = { from = "late" }
rate = { from = "system.rate / 1 Hz" }
)"};
  const auto engine = graphs.engine(
      "[inputs]\nx = {}\n[nodes]\npart = { use = \"part.toml\", x = \"x\", rate = \"1/16\" }\n"
      "[outputs]\nlow = { from = \"part.low\" }\nlate = { from = \"part.late\" }\n"
      "rate = { from = \"part.rate\" }\n");
  const auto out = test::run(*engine, {Samples(9600, 1.0)}, 9600, {64});
  CHECK(out[2][0] == 3000);
  // A step goes to 1 - e^(-2 pi f t), by the part's frame before.
  const double t = 5.0 / 3000;
  CHECK(out[0][16 * 5] == Approx(1 - std::exp(-2 * std::numbers::pi * 100 * t)).epsilon(0).margin(0.1));
  CHECK(out[0][9599] == Approx(1).epsilon(0).margin(1e-6));
  CHECK(out[1][15] == 0);
  CHECK(out[1][16] == 1);
}

TEST_CASE("part rate: a loop through a part is as long as its frames are", "[runtime]") {
  const PartGraphs graphs{R"([inputs]
x = {}
[nodes]
late = { type = "delay", in = "x", time = "2 / system.rate", interpolation = "none" }
[outputs]
y = { from = "late" }
)"};
  const auto engine = graphs.engine(
      "[inputs]\nx = {}\n[nodes]\nsum = \"x + 0.5 * part\"\n"
      "part = { use = \"part.toml\", x = \"sum\", rate = \"1/16\" }\n[outputs]\ny = { from = \"sum\" }\n");
  REQUIRE(engine->plan().loops.size() == 1);
  CHECK(engine->plan().loops[0].delay_frames == 32);
  CHECK(engine->plan().loops[0].sub_block == 32);
  const auto y = test::run(*engine, {test::impulse(200)}, 200, {64})[0];
  for (std::size_t n = 1; n < y.size(); ++n) {
    // Once around takes two frames of the part, 32 outside; each time it is held for 16.
    const auto round = n / 32;
    const double expected = round > 0 && n % 32 < 16 ? std::pow(0.5, static_cast<double>(round)) : 0.0;
    CHECK(y[n] == expected);
  }
}

TEST_CASE("part rate: holding and taking are no delay that closes a loop", "[runtime]") {
  const PartGraphs graphs{kPlain};
  CHECK(graphs.errors_of("[inputs]\nx = {}\n[nodes]\nsum = \"x + 0.1 * part\"\n"
                         "part = { use = \"part.toml\", x = \"sum\", rate = \"1/16\" }\n"
                         "[outputs]\ny = { from = \"sum\" }\n") ==
        "part.toml:3:1 Cycle part.x -> part.y -> sum -> part.x 'delay'");
}

TEST_CASE("part rate: blocks change no bit, whatever is in the part and around it", "[runtime]") {
  const RichGraphs graphs;
  const auto words = GENERATE(as<std::string>{}, "rate = \"1/16\"", "rate = \"1/7\", take = \"mean\"",
                              "rate = \"1/64\", between = \"line\"", "rate = \"1/200\"");
  constexpr int kFrames = 6000;
  const auto engine = graphs.engine(rich_user(words));
  engine->set_journal({{.frame = 1003, .kind = JournalEntry::Kind::ControlChange, .index = 0, .value = 0.9}});
  const auto in = excitation(kFrames);
  const auto out = test::run(*engine, in, kFrames, {64});
  REQUIRE(out[0][5000] != 0);
  for (const auto& blocks : {std::vector<int>{1}, std::vector<int>{16}, std::vector<int>{4096},
                             test::random_cutting(kFrames, 5, 300)})
    CHECK(test::first_difference(out, test::run(*engine, in, kFrames, blocks)) == "");
}

TEST_CASE("part rate: a fault silences the same frames for every block", "[runtime]") {
  const PartGraphs graphs{R"([inputs]
x = {}
[nodes]
line = { type = "delay", in = "x + line * 0.1 * x * x", time = "1 / system.rate", interpolation = "none" }
[outputs]
y = { from = "line" }
)"};
  const auto ratio = GENERATE(4, 16, 100);
  auto x = test::noise(2000, 2, 1, 2);
  x[800] = 1e200;  // on the grid of all three
  const auto engine = graphs.engine(user("rate = \"1/" + std::to_string(ratio) + "\""));
  const auto out = test::run(*engine, {x}, 2000, {64});
  REQUIRE(engine->faults().size() == 1);
  CHECK(engine->faults()[0].count == 1);
  // Silent to the end of the cell of 64 frames that the fault lies in: frame 831.
  CHECK(out[0][799] != 0);
  CHECK(std::all_of(out[0].begin() + 800, out[0].begin() + 832, [](double y) { return y == 0; }));
  CHECK(out[0][1100] != 0);
  for (const auto& blocks : {std::vector<int>{1}, test::random_cutting(2000, 7, 300)})
    CHECK(test::first_difference(out, test::run(*engine, {x}, 2000, blocks)) == "");
}

TEST_CASE("part rate: an edit of a part moves there at the part's rate, the same for every block",
          "[runtime]") {
  const RichGraphs graphs;
  const auto text = rich_user("rate = \"1/16\"");
  auto other = kRich;
  other.replace(other.find("600 Hz"), 6, "900 Hz");
  other.replace(other.find("0.6 * near"), 10, "0.1 * near");
  graphs.write("other.toml", other);
  auto edited = text;
  edited.replace(edited.find("part.toml"), 9, "other.toml");
  constexpr int kFrames = 4000;
  const auto in = excitation(kFrames);
  const auto play_edit = [&](const std::string& second, int block) {
    const auto engine = graphs.engine(text);
    REQUIRE(engine->prepare({48_kHz, 2, 4, 4096}));
    REQUIRE(engine->replace(graphs.right(second), 1501));
    Channels out(4, Samples(kFrames));
    for (int done = 0; done < kFrames; done += block) {
      const int now = std::min(block, kFrames - done);
      const double* from[] = {in[0].data() + done, in[1].data() + done};
      double* to[] = {out[0].data() + done, out[1].data() + done, out[2].data() + done, out[3].data() + done};
      engine->process({from, to, now});
    }
    return out;
  };
  const auto plain = test::run(*graphs.engine(text), in, kFrames, {64});
  CHECK(test::first_difference(plain, play_edit(text, 64)) == "");
  const auto moved = play_edit(edited, 64);
  CHECK(test::first_difference(plain, moved) != "");
  CHECK(test::first_difference(moved, play_edit(edited, 1)) == "");
  CHECK(test::first_difference(moved, play_edit(edited, 77)) == "");
  // Another rate is made of other nodes, which take over what they can.
  const auto faster = rich_user("rate = \"1/8\"");
  CHECK(test::first_difference(play_edit(faster, 64), play_edit(faster, 5)) == "");
}

TEST_CASE("part rate: a part at a sixteenth runs a sixteenth of the frames", "[runtime]") {
  const PartGraphs graphs{
      "[inputs]\nx = {}\n[nodes]\nm = { type = \"meter\", in = \"x\" }\n[outputs]\ny = { from = \"m\" }\n"};
  auto table = standard_nodes();
  table.types.push_back(&meter_type());
  for (const int ratio : {1, 16}) {
    const auto engine = graphs.engine(user("rate = \"1/" + std::to_string(ratio) + "\""), table);
    Meter::frames = 0;
    test::run(*engine, {Samples(4800)}, 4800, {37});
    CHECK(Meter::frames == 4800 / ratio);
  }
}

TEST_CASE("Player: every file that asks for the system delay receives the same", "[runtime]") {
  const PartGraphs graphs{"[outputs]\ny = { from = \"system.delay / 1 s\" }\n"};
  CompileOptions options;
  options.system_delay = 20_ms;
  const auto engine = graphs.engine(
      "[nodes]\npart = { use = \"part.toml\" }\nslow = { use = \"part.toml\", rate = \"1/16\" }\n"
      "[outputs]\na = { from = \"part\" }\nb = { from = \"slow\" }\nc = { from = \"system.delay / 1 s\" }\n",
      standard_nodes(), options);
  const auto out = test::run(*engine, {}, 100, {64});
  for (const auto& channel : out) CHECK(channel[99] == 0.02);
}
