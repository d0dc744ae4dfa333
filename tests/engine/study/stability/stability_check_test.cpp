#include "engine/study/stability/stability_check.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/nodes/table.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;

namespace {

StabilityReport checked(const std::string& text, double delay_s = 0.001, bool quick = true) {
  const auto graph = parse_graph_leniently(text, "test.toml");
  StabilityOptions options;
  options.world.delay = Seconds{delay_s};
  auto report = check_stability({nullptr, &graph, &standard_nodes()}, options, quick);
  if (!report) throw std::runtime_error(to_string(report.error()));
  return *report;
}

Stability answer(const std::string& text) { return checked(text).stability(); }

/// A loop of 5 ms with a gain of `gain`, around whatever `nodes` makes of it.
std::string signal_loop(const std::string& sum, const std::string& nodes = "") {
  return "format = 1\n[inputs]\nx = { unit = \"full scale\" }\n[nodes]\nsum = \"" + sum +
         "\"\nback = { type = \"delay\", in = \"sum\", time = \"5 ms\", interpolation = \"none\" }\n" +
         nodes + "[outputs]\ny = { from = \"sum\" }\n";
}

const auto kDevice =
    std::string{"format = 1\n[inputs]\nplace = { unit = \"m\" }\nspeed = { unit = \"m/s\" }\n[nodes]\n"};

}  // namespace

TEST_CASE("check: a loop behind a gate that an input opens is judged with the gate open", "[analysis]") {
  const auto* const gate =
      GENERATE(as<const char*>{}, "open = \"loud.gate\"\n",
               "open = { type = \"adsr\", gate = \"loud.gate\", attack = \"1 ms\", sustain = 1 }\n");
  const auto with = [&](double gain) {
    return signal_loop(fmt::format("x + {} * open * back", gain),
                       std::string{gate} + "loud = { type = \"threshold\", in = \"x\", level = 0.3 }\n");
  };
  CHECK(answer(with(0.99)) == Stability::Stable);
  const auto open = checked(with(1.01));
  CHECK(open.stability() == Stability::Unstable);
  CHECK(std::ranges::any_of(open.verdict.held, [](const HeldVerdict& held) {
    return held.input == "x" && held.level == 1 && held.stability == Stability::Unstable;
  }));
}

TEST_CASE("check: a product of moving signals is judged with its inputs at full scale", "[analysis]") {
  CHECK(answer(signal_loop("x + 0.99 * x * back")) == Stability::Stable);
  CHECK(answer(signal_loop("x + 1.01 * x * back")) == Stability::Unstable);
  // c v |x| up to 1 m, against b = 0.1 N s/m less what the delay of 1.01 ms makes of 1 N/m.
  const double border = 0.1 - 0.00101;
  const auto fed = [&](double share) {
    return kDevice +
           fmt::format(
               "fed = \"{} N s/m^2 * speed * abs(place)\"\n[outputs]\npush = {{ from = \"fed - 1 N/m * "
               "place\", unit = \"N\" }}\n",
               share * border);
  };
  CHECK(answer(fed(0.97)) == Stability::Stable);
  CHECK(answer(fed(1.03)) == Stability::Unstable);
}

TEST_CASE("check: a curve of an expression is judged where it is steepest", "[analysis]") {
  for (const auto* curve : {"tanh", "sin", "atan", "cos"}) {
    INFO(curve);
    CHECK(answer(signal_loop(fmt::format("x + 0.99 * {}(back)", curve))) == Stability::Stable);
    CHECK(answer(signal_loop(fmt::format("x + 1.01 * {}(back)", curve))) == Stability::Unstable);
  }
}

TEST_CASE("check: both values of a choice are judged", "[analysis]") {
  const auto with = [](double high) {
    return signal_loop(fmt::format("x + select(x > 0.3, {} * back, 0.5 * back)", high));
  };
  CHECK(answer(with(0.99)) == Stability::Stable);
  CHECK(answer(with(1.01)) == Stability::Unstable);
}

TEST_CASE("check: a loop through a comparison is event-driven", "[analysis]") {
  const auto report = checked(signal_loop("x + 0.5 * (back > 0.1)"));
  CHECK(report.stability() == Stability::Undecided);
  REQUIRE(report.verdict.events.size() == 1);
  CHECK(report.verdict.events.front().type == "operator >");
}

TEST_CASE("check: every straight line of a table counts, not only the steepest", "[analysis]") {
  const auto table = [](double left, double right) {
    return signal_loop(
        "x + bent",
        fmt::format("bent = {{ type = \"map\", in = \"low.low\", points = [[-1, {}], [0, 0], [1, {}]] }}\n"
                    "low = {{ type = \"one_pole\", in = \"back\", cutoff = \"20 Hz\" }}\n",
                    -left, right));
  };
  // A low-pass of 20 Hz after 5 ms: with positive feedback it holds up to 1, with negative up to 3.1, where
  // 60 Hz turn by half a circle.
  CHECK(answer(table(-1.5, 0.99)) == Stability::Stable);
  CHECK(answer(table(-1.5, 1.01)) == Stability::Unstable);
}

TEST_CASE("check: behind a corner that is taken off, a loop may be steeper than at rest", "[analysis]") {
  CHECK(answer(signal_loop("x + 0.99 * back - 0.5 * min(back, 0.2)")) == Stability::Stable);
  CHECK(answer(signal_loop("x + 1.01 * back - 0.5 * min(back, 0.2)")) == Stability::Unstable);
}

TEST_CASE("check: a minimum of two moving signals is either of them", "[analysis]") {
  CHECK(answer(signal_loop("x + min(0.99 * back, 0.5 * back)")) == Stability::Stable);
  CHECK(answer(signal_loop("x + min(1.01 * back, 0.5 * back)")) == Stability::Unstable);
  CHECK(answer(signal_loop("x + max(0.5 * back, 1.01 * back)")) == Stability::Unstable);
}

// A spring that is sampled once in N frames of T on a free device, m x'' = F - b x': with what is held acting
// for N T on average half a period late, K = b / (delay + N T / 2) where b N T / m is small (Gil et al. 2009,
// their sampling period N T).
TEST_CASE("check: a sampled place delays a spring by half of the clock's period", "[analysis]") {
  const int period = 49;
  const double late = 0.001 + 0.5 * period / 48000;
  const auto with = [&](double share) {
    return kDevice + fmt::format(
                         "tick = {{ type = \"sine\", frequency = \"{:.17g} Hz\" }}\n"
                         "now = {{ type = \"sample_hold\", in = \"place\", trigger = \"tick\" }}\n"
                         "pull = {{ type = \"spring\", in = \"now\", stiffness = {:.17g} }}\n"
                         "[outputs]\npush = {{ from = \"pull\", unit = \"N\" }}\n",
                         48000.0 / period, share * 0.1 / late);
  };
  CHECK(answer(with(0.98)) == Stability::Stable);
  CHECK(answer(with(1.02)) == Stability::Unstable);
}

TEST_CASE("check: what it cannot decide is undecided, with what to do", "[analysis]") {
  const auto* const undecided = GENERATE(
      as<const char*>{},
      // no clock
      "once = { type = \"threshold\", in = \"place\", level = \"1 mm\", hold = \"1 ms\" }\n"
      "now = { type = \"sample_hold\", in = \"place\", trigger = \"once\" }\n"
      "pull = { type = \"spring\", in = \"now\", stiffness = 5 }\n",
      // two clocks
      "tick = { type = \"sine\", frequency = \"4800 Hz\" }\ntack = { type = \"sine\", frequency = \"3000 "
      "Hz\" }\n"
      "now = { type = \"sample_hold\", in = \"place\", trigger = \"tick\" }\n"
      "then = { type = \"sample_hold\", in = \"now\", trigger = \"tack\" }\n"
      "pull = { type = \"spring\", in = \"then\", stiffness = 5 }\n",
      // a relay: nothing limits its events
      "far = { type = \"threshold\", in = \"place\", level = \"1 mm\" }\npull = \"1 N * far.gate\"\n");
  const auto report = checked(kDevice + undecided + "[outputs]\npush = { from = \"pull\", unit = \"N\" }\n");
  CHECK(report.stability() == Stability::Undecided);
  REQUIRE(report.verdict.doubts.size() >= 1);
  CHECK_FALSE(report.verdict.doubts[0].reason.empty());
  CHECK_FALSE(report.verdict.doubts[0].remedy.empty());
  CHECK(describe(report.verdict)[0].starts_with("undecided"));
}

TEST_CASE("check: an explicit network with a cubic spring is thrown where its steps are few", "[analysis]") {
  // At 1 m/s the spring turns a gram around in 2.62 (2 m / K v^2)^(1/4): 47 steps for 1e11 N/m^3, 0.8 for
  // 1e18.
  const auto with = [](double cubic) {
    return answer(fmt::format(
        "format = 1\n[networks.n]\nsolver = \"explicit\"\nground = {{ type = \"ground\" }}\n"
        "ball = {{ type = \"mass\", mass = \"1 g\", velocity = \"1 m/s\" }}\n"
        "hold = {{ type = \"spring\", between = [\"ground\", \"ball\"], stiffness = 0, cubic = {} }}\n"
        "[outputs]\nx = {{ from = \"n.ball.position\", unit = \"m\" }}\n",
        cubic));
  };
  CHECK(with(1e11) == Stability::Stable);
  CHECK(with(1e18) == Stability::Unstable);
}

// x+ = 2 x - x- - T^2/m (k x + K x^3 + c (x - x-)/T), written out, is beyond 10 m after 74 frames.
TEST_CASE("check: a cubic spring that throws its mass away within a few frames is refused", "[analysis]") {
  const auto* const text = R"(format = 1
[networks.n]
solver = "explicit"
ground = { type = "ground" }
ball = { type = "mass", mass = "65 g", at = "0.24 mm", velocity = "3.7 m/s" }
hold = { type = "spring", between = ["ground", "ball"], stiffness = 3.2e7, damping = 7.3, cubic = 2.4e15 }
[outputs]
x = { from = "n.ball.position", unit = "m" }
)";
  CHECK(answer(text) == Stability::Unstable);
}

// At another rate the loop would be shorter than a frame.
TEST_CASE("check: runs at rates at which a graph cannot be made are left out", "[analysis]") {
  const auto report = checked(
      "format = 1\n[inputs]\nx = { unit = \"full scale\" }\n[nodes]\nsum = \"x + 0.5 * back\"\nback = { type "
      "= "
      "\"delay\", in = \"sum\", time = \"0.1 ms\" }\n[outputs]\ny = { from = \"sum\" }\n",
      0, false);
  CHECK(report.stability() == Stability::Stable);
  CHECK(std::ranges::none_of(report.runs, [](const ExtremeRun& run) { return run.rate.value == 8000; }));
  CHECK(std::ranges::any_of(report.runs, [](const ExtremeRun& run) { return run.rate.value == 96000; }));
}

// Where one gesture is highest the other one is at half, so that their product is 8/9 of what it is half-way
// between: 1.5 * 0.75 against 2 * 0.5.
TEST_CASE("check: gestures are judged between their extremes, too", "[analysis]") {
  const test::TemporaryFolder folder;
  const double border = 0.1 / (0.005 + 0.5 / 48000);
  folder.write("i.toml", R"(format = 1
[inputs]
x = { unit = "m" }
[controls]
k = { value = "0 N/m", range = ["0 N/m", "1 kN/m"] }
share = { value = 0, range = [0, 1] }
[nodes]
pull = { type = "spring", in = "x", stiffness = "k * share" }
[outputs]
motor = { from = "pull / 1 N" }
)");
  folder.write("p.toml", R"(format = 1
[inputs]
f = { unit = "full scale" }
[networks.n]
ground = { type = "ground" }
a = { type = "mass", mass = "50 g" }
b = { type = "damper", between = ["ground", "a"], damping = "0.1 N s/m" }
p = { type = "force", on = "a", force = "1 N * f" }
[outputs]
x = { from = "n.a.position", unit = "m" }
)");
  const auto played = [&](double between) {
    folder.write("scene.toml", fmt::format(R"(format = 1
delay = "5 ms"
duration = "1 s"
[parts]
instrument = {{ use = "i.toml", x = "plant.x", k = "harder", share = "less" }}
plant = {{ use = "p.toml", f = "instrument.motor" }}
[gestures]
harder = {{ points = [["0.2 s", "{:.9g} N/m"], ["0.8 s", "{:.9g} N/m"]] }}
less = {{ points = [["0.2 s", 1], ["0.8 s", 0.5]] }}
[converters]
off = true
)",
                                           between * border * 8 / 9, between * border * 16 / 9));
    const auto scene = load_scene_leniently(folder.path() / "scene.toml");
    StabilityOptions options;
    options.world.delay = scene.scene->delay;
    const auto report = check_stability({&scene, nullptr, &standard_nodes()}, options, true);
    REQUIRE(report);
    return report->stability();
  };
  CHECK(played(0.98) == Stability::Stable);
  CHECK(played(1.02) == Stability::Unstable);
}

TEST_CASE("check: a large gain is no growth, and a loop shorter than a frame elsewhere no error",
          "[analysis]") {
  // Roots at -507 /s and, where it stands, 0; an impulse of 1 m gives 1.2e6 N once.
  CHECK(checked(
            "format = 1\n[inputs]\nx = { unit = \"m\" }\n[nodes]\nv = { type = \"difference\", in = \"x\" }\n"
            "[outputs]\nf = { from = \"-25 N s/m * v\", unit = \"N\" }\n",
            0.001, false)
            .stability() == Stability::Stable);
  // 50 us are less than a frame at 8 kHz.
  CHECK(checked("format = 1\n[inputs]\nmic = { unit = \"full scale\" }\n[nodes]\n"
                "d = { type = \"delay\", in = \"s\", time = \"50 us\", interpolation = \"none\" }\n"
                "f = { type = \"one_pole\", in = \"d\", cutoff = \"5 kHz\" }\ns = \"mic + 0.5 * f\"\n"
                "[outputs]\ny = { from = \"f\" }\n",
                0.001, false)
            .stability() == Stability::Stable);
}
