#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "engine/runtime/player.h"
#include "tests/support/allocation_count.h"
#include "tests/support/error_summary.h"
#include "tests/support/graphs/busy_graph.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"

using namespace tactus;
using test::engine_of;

namespace {

using Kind = JournalEntry::Kind;

std::string graph(const std::string& body) { return "format = 1\nname = \"test\"\n" + body; }

std::unique_ptr<Plan> schedule_of(const std::string& text) {
  auto made = compile(parse_graph_leniently(text, "test.toml"), standard_nodes(), {});
  if (!made) throw std::runtime_error(to_string(made.error()));
  return std::move(*made);
}

const std::string kBig = test::kBusyGraph + R"(hiss   = { type = "noise", level = 0.1 }
[outputs]
y = { from = "all + tuned + hiss" }
z = { from = "back" }
)";

struct Edit {
  int frame;
  std::string text;
};

/// Runs with the edits at their frames, whatever the block.
test::Channels play(const std::string& first, const std::vector<Edit>& edits, const test::Channels& inputs,
                    int frames, int block, const std::vector<JournalEntry>& journal = {}) {
  const auto engine = engine_of(first);
  const StreamFormat format{48_kHz, static_cast<int>(inputs.size()), engine->out_channels(), 4096};
  if (!engine->prepare(format)) throw std::runtime_error("not prepared");
  engine->set_journal(journal);
  test::Channels out(static_cast<std::size_t>(engine->out_channels()),
                     test::Samples(static_cast<std::size_t>(frames)));
  std::size_t next = 0;
  for (int done = 0; done < frames;) {
    if (next < edits.size() && !engine->replacing()) {
      const auto status = engine->replace(schedule_of(edits[next].text), edits[next].frame);
      if (!status) throw std::runtime_error(to_string(status.error()));
      ++next;
    }
    const int now = std::min(block, frames - done);
    std::vector<const double*> in;
    std::vector<double*> to;
    for (const auto& channel : inputs) in.push_back(channel.data() + done);
    for (auto& channel : out) to.push_back(channel.data() + done);
    engine->process({in.data(), to.data(), now});
    done += now;
  }
  return out;
}

/// One output "y" made from the input x.
std::string simple(const std::string& y, const std::string& nodes = "") {
  return graph("[inputs]\nx = {}\n[nodes]\n" + nodes + "\n[outputs]\ny = { from = \"" + y + "\" }\n");
}

double largest_step(const test::Samples& y, int from, int to) {
  double largest = 0;
  for (int n = from; n < to; ++n)
    largest =
        std::max(largest, std::abs(y[static_cast<std::size_t>(n)] - y[static_cast<std::size_t>(n - 1)]));
  return largest;
}

test::Channels excitation(int frames) {
  auto go = test::Samples(static_cast<std::size_t>(frames));
  for (int n = 100; n < frames; n += 1777) go[static_cast<std::size_t>(n)] = 1;
  return {test::noise(frames, 11), go};
}

}  // namespace

TEST_CASE("Player: an edit that changes nothing changes no bit", "[runtime][replace]") {
  constexpr int kFrames = 6000;
  const std::vector<JournalEntry> journal{{300, Kind::ControlChange, 1, 700},
                                          {2900, Kind::ControlChange, 0, 0.1}};
  const auto inputs = excitation(kFrames);
  const auto expected = play(kBig, {}, inputs, kFrames, 64, journal);
  // In the middle of both ramps too. Comments, empty lines and the order of sections are no changes.
  const std::vector<Edit> edits{
      {1, kBig}, {450, "# nothing\n\n" + kBig}, {2901, kBig}, {3000, kBig}, {4097, kBig}};
  for (const int block : {1, 64, 100}) {
    INFO("blocks of " << block);
    CHECK(test::first_difference(expected, play(kBig, edits, inputs, kFrames, block, journal)) == "");
  }
}

TEST_CASE("Player: an edit takes over at its frame in blocks of any size", "[runtime][replace]") {
  constexpr int kFrames = 3000;
  auto edited = kBig;
  edited.replace(edited.find("0.9 * damped"), 12, "abs(0.8 * damped)");
  edited.replace(edited.find("\"12 ms\""), 7, "\"30 ms\"");
  const auto inputs = excitation(kFrames);
  const std::vector<Edit> edits{{777, edited}, {2001, kBig}};
  const auto expected = play(kBig, edits, inputs, kFrames, 1);
  CHECK(test::first_difference(play(kBig, {}, inputs, kFrames, 1), expected) != "");
  for (const int block : {7, 64, 256, 700})
    CHECK(test::first_difference(expected, play(kBig, edits, inputs, kFrames, block)) == "");
}

TEST_CASE("Player: a constant that is edited moves to its new value in 10 ms", "[runtime][replace]") {
  const test::Samples ones(2000, 1.0);
  const auto y =
      play(simple("0.8 * x"), {{100, simple("0.2 * x")}, {340, simple("0.6 * x")}}, {ones}, 2000, 64)[0];
  CHECK(y[99] == 0.8);
  CHECK(y[100] == 0.8);
  CHECK(y[100 + 120] == Approx(0.8 - 0.6 * 120 / 480).epsilon(1e-12));
  CHECK(y[340] == Approx(0.5).epsilon(1e-12));  // half way; from there to 0.6
  CHECK(y[340 + 240] == Approx(0.55).epsilon(1e-12));
  CHECK(y[340 + 480] == 0.6);
  CHECK(y[1999] == 0.6);
}

TEST_CASE("Player: an edited parameter leaves the node its state", "[runtime][replace]") {
  // A one-pole charged to 1 stays at 1 whatever its cutoff becomes; made anew it would start at 0.
  const auto filter = [](const char* cutoff) {
    return simple("slow",
                  "slow = { type = \"one_pole\", in = \"x\", cutoff = \"" + std::string(cutoff) + "\" }");
  };
  const auto y = play(filter("500 Hz"), {{5000, filter("40 Hz")}}, {test::Samples(8000, 1.0)}, 8000, 64)[0];
  for (std::size_t n = 5000; n < 8000; ++n) REQUIRE(y[n] == Approx(1.0).epsilon(1e-9));
}

TEST_CASE("Player: an output that would jump gets an offset that fades on a line", "[runtime][replace]") {
  const auto y =
      play(simple("0.8 * x"), {{100, simple("abs(x) - 0.7")}}, {test::Samples(1000, 1.0)}, 1000, 64)[0];
  for (int n = 100; n < 1000; ++n) {
    const double left = std::max(0.0, 1.0 - (n - 100) / 480.0);
    REQUIRE(y[static_cast<std::size_t>(n)] == Approx(0.3 + 0.5 * left).epsilon(1e-12));
  }
}

TEST_CASE("Player: no edit makes a step beyond those of the old and the new signal and the fade",
          "[runtime][replace]") {
  constexpr int kFrames = 4000, kEdit = 1999;
  const std::string sine = "s = { type = \"sine\", frequency = \"441 Hz\" }\n";
  const std::vector<std::string> versions{
      simple("s", sine),
      simple("0.3 * s", sine),
      simple("min(s, 0.1) + 0.5", sine),
      simple("s + late", sine + "late = { type = \"delay\", in = \"s + 0.5 * late\", time = \"7 ms\" }"),
      simple("s + late", sine + "late = { type = \"delay\", in = \"s + 0.5 * late\", time = \"9 ms\" }"),
      simple("low", sine + "low = { type = \"low_pass\", in = \"s\", cutoff = \"200 Hz\" }"),
      simple("low", sine + "low = { type = \"high_pass\", in = \"s\", cutoff = \"200 Hz\" }"),
      simple("-0.9"),
  };
  const test::Channels inputs{test::Samples(kFrames)};
  for (const auto& from : versions) {
    for (const auto& to : versions) {
      const auto before = play(from, {}, inputs, kFrames, 64)[0];
      // What a delay that was not there before answers first is a step of the new signal's own.
      const auto after = play(simple("1e-9 * s", sine), {{kEdit, to}}, inputs, kFrames, 64)[0];
      const auto y = play(from, {{kEdit, to}}, inputs, kFrames, 64)[0];
      const double own = std::max(largest_step(before, 1, kFrames), largest_step(after, 1, kFrames));
      const double peak = 4;  // no two of these signals are further apart
      INFO(from << "\nto\n" << to);
      CHECK(y[kEdit] == Approx(y[kEdit - 1]).margin(from == to ? own : 1e-12));
      CHECK(largest_step(y, kEdit, kFrames) <= own + peak / 480 + 1e-9);
    }
  }
}

TEST_CASE("Player: an output that an edit does not reach keeps every bit", "[runtime][replace]") {
  const auto two = [](const std::string& z) {
    return graph(
        "[inputs]\nx = {}\n[nodes]\nline = { type = \"delay\", in = \"x + 0.7 * line\", time = \"3 ms\" }\n"
        "[outputs]\ny = { from = \"line\" }\nz = { from = \"" +
        z + "\" }\n");
  };
  const test::Channels inputs{test::noise(3000, 5)};
  const auto expected = play(two("x"), {}, inputs, 3000, 64);
  const auto edited = play(two("x"), {{1000, two("abs(x) + 0.2 * line")}}, inputs, 3000, 64);
  CHECK(test::first_difference({expected[0]}, {edited[0]}) == "");
  CHECK(test::first_difference({expected[1]}, {edited[1]}) != "");
}

TEST_CASE("Player: controls keep value and number through edits, unless the file gives them another value",
          "[runtime][replace]") {
  const auto with = [](const std::string& controls) {
    return graph("[controls]\n" + controls + "[outputs]\ny = { from = \"b\" }\nz = { from = \"c\" }\n");
  };
  const std::string a = "a = { value = 0, range = [0, 1] }\n", b = "b = { value = 0.5, range = [0, 1] }\n",
                    c = "c = { value = 0.25, range = [0, 1] }\n";
  const auto engine = engine_of(with(a + b + c));
  REQUIRE(engine->prepare({48_kHz, 0, 2, 64}));
  double y[64], z[64];
  double* out[] = {y, z};
  const auto run = [&](int blocks) {
    for (int i = 0; i < blocks; ++i) engine->process({nullptr, out, 64});
  };
  REQUIRE(engine->post({JournalEntry::kNow, Kind::ControlChange, engine->control_index("b"), 0.75}));
  run(10);
  CHECK(y[63] == 0.75);
  const int number_of_c = engine->control_index("c");
  REQUIRE(engine->replace(schedule_of(with("d = { value = 1, range = [0, 2] }\n" + c + b))));
  run(10);
  CHECK(y[63] == 0.75);
  CHECK(z[63] == 0.25);
  CHECK(engine->control_index("a") == -1);
  CHECK(engine->control_index("c") == number_of_c);
  REQUIRE(engine->post({JournalEntry::kNow, Kind::ControlChange, number_of_c, 0.5}));
  run(10);
  CHECK(z[63] == 0.5);
  REQUIRE(engine->replace(schedule_of(with(a + "b = { value = 0.125, range = [0, 1] }\n" + c))));
  run(10);
  CHECK(y[63] == 0.125);
  CHECK(z[63] == 0.5);
  CHECK(engine->control_index("a") == 0);
}

TEST_CASE("Player: what cannot take over is refused, and the sounding graph plays on", "[runtime][replace]") {
  const auto engine = engine_of(simple("x"));
  REQUIRE(engine->prepare({48_kHz, 1, 1, 64}));
  const auto refused = [&](const std::string& text) {
    const auto status = engine->replace(schedule_of(text));
    return test::summary(status);
  };
  CHECK(refused(graph("[inputs]\nother = {}\n[outputs]\ny = { from = \"other\" }\n")) == "BadArgument");
  CHECK(refused(graph("[inputs]\nx = {}\n[outputs]\nz = { from = \"x\" }\n")) == "BadArgument");
  CHECK(refused(simple("2 * x")) == "");
  CHECK(refused(simple("3 * x")) == "BadArgument");
  const test::Samples x(64, 0.25);
  test::Samples y(64);
  const double* in[] = {x.data()};
  double* out[] = {y.data()};
  for (int block = 0; block < 20; ++block) engine->process({in, out, 64});
  CHECK(y[63] == 0.5);
  CHECK(refused(simple("3 * x")) == "");
}

TEST_CASE("Player: taking over allocates nothing and loses no fault", "[runtime][replace]") {
  const auto text = simple("x * 1e200 * 1e200 * x");
  const auto engine = engine_of(text);
  REQUIRE(engine->prepare({48_kHz, 1, 1, 64}));
  const test::Samples x(64, 1.0);
  test::Samples y(64);
  const double* in[] = {x.data()};
  double* out[] = {y.data()};
  engine->process({in, out, 64});
  REQUIRE(engine->faults().size() == 1);
  const auto path = engine->faults()[0].path;
  const auto count = engine->faults()[0].count;
  REQUIRE(engine->replace(schedule_of(simple("x", "unused = \"x\""))));
  const auto before = test::allocation_count();
  engine->process({in, out, 64});
  CHECK(test::allocation_count() == before);
  CHECK_FALSE(engine->replacing());
  REQUIRE(engine->replace(schedule_of(simple("x"))));
  engine->process({in, out, 64});
  REQUIRE(engine->faults().size() == 1);
  CHECK(engine->faults()[0].path == path);
  CHECK(engine->faults()[0].count == count);
}

namespace {

/// Swaps between versions of a graph, every second of them broken, with blocks in between.
void swap_and_check(int swaps) {
  auto other = kBig;
  other.replace(other.find("0.9 * damped"), 12, "abs(0.8 * damped)");
  other.replace(other.find("35 g"), 4, "30 g");
  other.replace(other.find("to = \"9 ms\""), 11, "to = \"8 ms\"");
  auto third = kBig;
  third.replace(third.find("level = 0.1"), 11, "level = 0.2");
  const std::vector<std::string> good{other, kBig, third, kBig};
  const std::vector<std::string> bad{kBig.substr(0, 900), kBig + "[nodes.extra]\ntype = \"delay\"\n",
                                     graph("[outputs]\nq = { from = \"1 V + 1 m\" }\n"), "\x01\xff = [[["};
  const auto engine = engine_of(kBig);
  REQUIRE(engine->prepare({48_kHz, 2, 2, 64}));
  const auto inputs = excitation(6400);
  double y[64], z[64];
  double* out[] = {y, z};
  std::int64_t live = 0;
  double largest = 0;
  for (int swap = 0; swap < swaps; ++swap) {
    const auto turn = static_cast<std::size_t>(swap / 2 % 4);
    const auto& text = (swap % 2 == 0 ? good : bad)[turn];
    auto made = compile(parse_graph_leniently(text, "test.toml"), standard_nodes(), {});
    REQUIRE(made.has_value() == (swap % 2 == 0));
    if (made) REQUIRE(engine->replace(std::move(*made)));
    const auto from = static_cast<std::size_t>(swap % 100 * 64);
    const double* in[] = {inputs[0].data() + from, inputs[1].data() + from};
    engine->process({in, out, 64});
    for (int n = 0; n < 64; ++n) largest = std::max({largest, std::abs(y[n]), std::abs(z[n])});
    if (swap == 99) live = test::live_allocations();
  }
  // Catch2 keeps nothing for what passes; the same versions stand at the same turns.
  CHECK(std::abs(test::live_allocations() - live) < 100);
  CHECK(engine->faults().empty());
  CHECK(largest > 0.01);
  CHECK(largest < 100);
}

}  // namespace

TEST_CASE("Player: swaps, half of them of broken files, cost no fault and no memory", "[runtime][replace]") {
  swap_and_check(1000);
}

// tactus_tests "[replace-soak]": 2 minutes or so.
TEST_CASE("Player: a hundred thousand swaps, half of them broken", "[.][replace-soak]") {
  swap_and_check(100'000);
}

TEST_CASE("Player: a delay whose longest time is edited goes on with what it remembers",
          "[runtime][replace]") {
  const auto late = [](const char* time) {
    return simple("late", "late = { type = \"delay\", in = \"x\", time = \"" + std::string(time) +
                              "\", interpolation = \"none\" }");
  };
  auto x = test::Samples(3000);
  for (std::size_t n = 0; n < x.size(); ++n) x[n] = static_cast<double>(n);
  const auto y = play(late("10 ms"), {{1000, late("15 ms")}}, {x}, 3000, 64)[0];
  CHECK(y[999] == 999 - 480);
  CHECK(y[1000] == y[999]);
  for (std::size_t n = 1480; n < 3000; ++n) REQUIRE(y[n] == static_cast<double>(n) - 720);
}

TEST_CASE("Player: a network whose stiffness is edited goes on from where it is", "[runtime][replace]") {
  // A mass at rest 1 mm up on its spring: whatever the stiffness becomes, it starts from 1 mm.
  const auto hung = [](const char* stiffness) {
    return graph(
        "[networks.n]\nframe = { type = \"ground\" }\nm = { type = \"mass\", mass = \"10 g\" }\n"
        "s = { type = \"spring\", between = [\"frame\", \"m\"], stiffness = \"" +
        std::string(stiffness) +
        "\", damping = \"2 kg/s\" }\npush = { type = \"force\", on = \"m\", force = \"1 N\" }\n"
        "[outputs]\ny = { from = \"n.m.position * 1000\", unit = \"m\" }\n");
  };
  constexpr int kEdit = 24000, kFrames = 48000;
  const auto y = play(hung("1000 N/m"), {{kEdit, hung("500 N/m")}}, {}, kFrames, 64)[0];
  CHECK(y[kEdit - 1] == Approx(1.0).epsilon(1e-6));  // 1 N over 1000 N/m, in mm
  CHECK(y[kEdit] == y[kEdit - 1]);
  CHECK(y[kFrames - 1] == Approx(2.0).epsilon(1e-6));
  for (std::size_t n = kEdit; n < kFrames; ++n) REQUIRE(y[n] > 0.99);  // it never falls back to 0
}

TEST_CASE("Player: a network goes on whatever solver an edit makes right for it", "[runtime][replace]") {
  // A mass that hums on a spring of 1 kHz keeps its amplitude when the spring becomes one of 1200 Hz, by the
  // step of `auto`, by several steps, by another method; 2 x pi x 1 mm x 1 kHz = 6.28 m/s.
  const auto humming = [](const char* stiffness, const char* how) {
    return graph(std::string("[networks.n]\n") + how +
                 "\nm = { type = \"oscillator\", mass = \"1 g\", damping = \"0 N s/m\", velocity = \"6.283 "
                 "m/s\", stiffness = "
                 "\"" +
                 stiffness + "\" }\n[outputs]\ny = { from = \"n.m.position / 1 mm\" }\n");
  };
  const auto loudest = [](const test::Samples& y, std::size_t from, std::size_t to) {
    return *std::max_element(y.begin() + from, y.begin() + to);
  };
  constexpr int kEdit = 4800;
  constexpr double kStiff = 39478;  // (2 pi 1 kHz)^2 x 1 g
  const char* const ways[] = {"solver = \"auto\"", "solver = \"auto\"\noversample = 4", "solver = \"exact\"",
                              "solver = \"reference\"", "solver = \"passive\""};
  for (const auto* way : ways) {
    INFO(way);
    const auto stiffness = std::to_string(kStiff) + " N/m", stiffer = std::to_string(1.44 * kStiff) + " N/m";
    const auto y =
        play(humming(stiffness.c_str(), way), {{kEdit, humming(stiffer.c_str(), way)}}, {}, 9600, 64)[0];
    CHECK(loudest(y, 0, kEdit) == Approx(1.0).epsilon(0.01));
    // The energy at the edit lies between that of the old spring and 1.44 times it.
    CHECK(loudest(y, kEdit + 480, 9600) < 1.02);
    CHECK(loudest(y, kEdit + 480, 9600) > 0.81);
  }
  // `auto` takes another solver for a spring that rings at 5 kHz than for one at 32 Hz. What the slow one is
  // stretched by, 31.4 mm x sin(200 x 0.1), is the amplitude of the fast one.
  const auto slow = humming("40 N/m", ways[0]), fast = humming("1000 kN/m", ways[0]);
  const auto solver = [](const std::string& text) { return schedule_of(text)->nodes.front()->about(); };
  CHECK(solver(slow) != solver(fast));
  const auto y = play(slow, {{kEdit, fast}}, {}, 9600, 64)[0];
  CHECK(loudest(y, kEdit + 480, 9600) == Approx(31.415 * 0.9129).epsilon(0.01));
}

TEST_CASE("Player: parts of a network that an edit begins or ceases to read", "[runtime][replace]") {
  const auto network = [](const char* read, const char* friction = "0 N") {
    return graph(std::string("[networks.n]\nsolver = \"passive\"\n"
                             "one = { type = \"oscillator\", mass = \"1 g\", frequency = \"300 Hz\", "
                             "damping_ratio = 0.001, velocity = \"1 m/s\" }\n"
                             "floor = { type = \"ground\" }\n"
                             "rub = { type = \"friction\", between = [\"floor\", \"one\"], normal = \"") +
                 friction +
                 "\" }\n"
                 "two = { type = \"oscillator\", mass = \"1 g\", frequency = \"500 Hz\", damping_ratio = "
                 "0.001, velocity = \"2 m/s\" }\n"
                 "hand = { type = \"hand\", on = \"two\", stiffness = \"100 N/m\", position = \"3 mm\" }\n"
                 "[outputs]\ny = { from = \"(" +
                 read + ") / 1 m\" }\n");
  };
  const auto one = play(network("n.one.position"), {}, {}, 4000, 64)[0];
  const auto two = play(network("n.two.position"), {}, {}, 4000, 64)[0];
  const auto late =
      play(network("n.one.position"), {{1000, network("n.one.position + n.two.position")}}, {}, 4000, 64)[0];
  // What was there goes on, and what is new starts; the output fades from the one to the other. A hand that
  // is new pulls from its first step on, not from half a step before it.
  const double largest = *std::max_element(two.begin(), two.end());
  for (std::size_t n = 0; n < 1000; ++n) REQUIRE(late[n] == one[n]);
  for (std::size_t n = 2000; n < 4000; ++n)
    REQUIRE(late[n] == Approx(one[n] + two[n - 1000]).margin(3e-3 * largest));
  const auto less =
      play(network("n.one.position + n.two.position"), {{1000, network("n.one.position")}}, {}, 4000, 64)[0];
  for (std::size_t n = 2000; n < 4000; ++n) REQUIRE(less[n] == Approx(one[n]).margin(1e-12));
  // A friction that begins to press stops the mass; one that ceases lets it go on as it was.
  const auto pressed =
      play(network("n.one.position"), {{1000, network("n.one.position", "1 N")}}, {}, 4000, 64)[0];
  CHECK(pressed[3999] == Approx(pressed[3000]).margin(1e-9));
  CHECK(std::abs(pressed[1000] - one[1000]) < 1e-4);
}

TEST_CASE("Player: a fixed point of a network that an edit moves is there", "[runtime][replace]") {
  const auto hung = [](const char* at) {
    return graph(std::string("[networks.n]\nframe = { type = \"ground\", at = \"") + at +
                 "\" }\nm = { type = \"mass\", mass = \"1 g\" }\ns = { type = \"spring\", between = "
                 "[\"frame\", \"m\"], "
                 "stiffness = \"1 kN/m\", damping = \"1 N s/m\" }\n[outputs]\ny = { from = \"n.m.position / "
                 "1 mm\" }\n");
  };
  const auto y = play(hung("0 mm"), {{1000, hung("2 mm")}}, {}, 9600, 64)[0];
  CHECK(y[999] == 0.0);
  CHECK(y[9599] == Approx(2.0));
}

TEST_CASE("Player: nodes that were one go on each with its state when an edit separates them",
          "[runtime][replace]") {
  // Two strings that ring alike, of which one is then tuned, and two echoes of which one becomes longer.
  const auto strings = [](const char* second, const char* time) {
    return graph(std::string("[inputs]\nx = {}\n[nodes]\n"
                             "a = { type = \"string\", in = \"x\", pitch = \"200 Hz\" }\n"
                             "b = { type = \"string\", in = \"x\", pitch = \"") +
                 second +
                 "\" }\nc = { type = \"delay\", in = \"a\", time = \"4 ms\" }\n"
                 "d = { type = \"delay\", in = \"a\", time = \"" +
                 time +
                 "\" }\n"
                 "[outputs]\na = { from = \"a\" }\nb = { from = \"b\" }\nc = { from = \"c\" }\nd = { from = "
                 "\"d\" }\n");
  };
  const auto merged = strings("200 Hz", "4 ms"), tuned = strings("200.1 Hz", "5 ms");
  CHECK(schedule_of(merged)->nodes.size() == 2);
  CHECK(schedule_of(tuned)->nodes.size() == 4);
  test::Samples pluck(6000, 0.0);
  pluck[0] = 1.0;
  const auto plain = play(merged, {}, {pluck}, 6000, 64);
  const auto edited = play(merged, {{2400, tuned}}, {pluck}, 6000, 64);
  CHECK(edited[0] == plain[0]);
  CHECK(edited[2] == plain[2]);
  for (std::size_t n = 0; n < 2400; ++n) REQUIRE(edited[1][n] == plain[1][n]);
  const auto loudest = [](const test::Samples& y) {
    double most = 0.0;
    for (std::size_t n = 2400; n < 6000; ++n) most = std::max(most, std::abs(y[n]));
    return most;
  };
  // It rings on; other taps round the pulse off.
  CHECK(loudest(edited[1]) == Approx(loudest(plain[1])).epsilon(0.2));
  CHECK(edited[1] != plain[1]);
  // After the fade the longer echo has what was in the line before the edit: a 1 ms later.
  for (std::size_t n = 2400 + 480; n < 2400 + 960; ++n)
    REQUIRE(edited[3][n] == Approx(plain[0][n - 240]).margin(1e-12));
  // What is merged again is the first of them.
  const auto again = play(tuned, {{2400, merged}}, {pluck}, 6000, 64);
  CHECK(again[0] == plain[0]);
  for (std::size_t n = 5000; n < 6000; ++n) REQUIRE(again[1][n] == again[0][n]);
}

TEST_CASE("Player: edits from another thread all arrive", "[runtime][replace]") {
  const auto engine = engine_of(simple("0 + x"));
  REQUIRE(engine->prepare({48_kHz, 1, 1, 64}));
  std::atomic<bool> stop{false};
  double last = 0;
  std::thread audio{[&] {
    const test::Samples x(64, 1.0);
    test::Samples y(64);
    const double* in[] = {x.data()};
    double* out[] = {y.data()};
    while (!stop) engine->process({in, out, 64});
    for (int block = 0; block < 20; ++block) engine->process({in, out, 64});
    last = y[63];
  }};
  for (int edit = 1; edit <= 300;) {
    const auto text =
        edit % 3 == 0 ? simple("abs(x) * " + std::to_string(edit)) : simple("x * " + std::to_string(edit));
    if (engine->replace(schedule_of(text)))
      ++edit;
    else
      std::this_thread::yield();
  }
  stop = true;
  audio.join();
  CHECK(last == 300);
}

TEST_CASE("Player: an edited string, comb or filter goes on sounding", "[runtime][replace]") {
  constexpr int kFrames = 9600, kEdit = 4800;
  const auto string = [](const std::string& voices, const std::string& pitch) {
    return simple("s", "g = { type = \"string\", in = \"x\", pitch = \"" + pitch +
                           "\", gain = 0.999, loss = 0.1" + voices +
                           " }\ns = { type = \"mix\", in = \"g\" }");
  };
  const auto comb = [](const std::string& voices, const std::string& time) {
    return simple("s", "d = { type = \"delay\", in = \"x + 0.999 * d\", time = \"" + time + "\"" + voices +
                           " }\ns = { type = \"mix\", in = \"d\" }");
  };
  struct Case {
    std::string before, after;
  };
  for (const auto& c : {Case{string("", "200 Hz"), string("", "201 Hz")},
                        Case{string(", voices = 8", "200 Hz"), string(", voices = 8", "201 Hz")},
                        Case{comb("", "5 ms"), comb("", "5.0625 ms")},
                        Case{comb(", voices = 8", "5 ms"), comb(", voices = 8", "5.0625 ms")}}) {
    INFO(c.after);
    auto pluck = test::noise(kFrames, 5);
    std::fill(pluck.begin() + 960, pluck.end(), 0.0);
    const auto edited = play(c.before, {{kEdit, c.after}}, {pluck}, kFrames, 64)[0];
    const auto alone = play(c.before, {}, {pluck}, kFrames, 64)[0];
    double loud = 0, kept = 0;
    for (int n = kEdit + 960; n < kFrames; ++n) {
      loud += alone[static_cast<std::size_t>(n)] * alone[static_cast<std::size_t>(n)];
      kept += edited[static_cast<std::size_t>(n)] * edited[static_cast<std::size_t>(n)];
    }
    CHECK(loud > 1e-3);
    CHECK(kept > 0.5 * loud);
  }
}

TEST_CASE("Player: a control that jumps at once when it is played moves when the file is edited",
          "[runtime][replace]") {
  const auto with = [](const std::string& value) {
    return graph("[inputs]\nx = {}\n[controls]\ng = { value = " + value +
                 ", smooth = \"0 ms\" }\n[outputs]\ny = { from = \"g + 0 * x\" }\n");
  };
  const auto out = play(with("0.9"), {{500, with("0.1")}}, {test::Samples(2000)}, 2000, 64)[0];
  CHECK(out.front() == 0.9);
  CHECK(out.back() == 0.1);
  CHECK(largest_step(out, 1, 2000) == Approx(0.8 / 480).epsilon(1e-6));
}

TEST_CASE("Player: the silence after a fault outlasts an edit that changes nothing", "[runtime][replace]") {
  const auto text = simple("d", "d = { type = \"delay\", in = \"x + 0.5 * d\", time = \"1 ms\" }");
  auto burst = test::noise(1000, 3);
  burst[200] = 1e308;
  burst[248] = 1e308;
  burst[296] = 1e308;
  burst[344] = 1e308;
  const auto plain = play(text, {}, {burst}, 1000, 1)[0];
  for (int frame = 300; frame < 460; frame += 20)
    CHECK(play(text, {{frame, text}}, {burst}, 1000, 1)[0] == plain);
}
