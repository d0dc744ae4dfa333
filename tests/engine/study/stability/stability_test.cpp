#include "engine/study/stability/stability.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/nodes/table.h"
#include "engine/study/stability/stability_extremes.h"

using namespace tactus;

namespace {

/// A device on a virtual spring: the instrument alone, the device is the assumed one.
std::string spring_text(double stiffness, double damping = 0) {
  return fmt::format(R"(
format = 1
[inputs]
place = {{ unit = "m" }}
speed = {{ unit = "m/s" }}
[nodes]
pull = {{ type = "spring", in = "place", stiffness = {} }}
drag = {{ type = "damper", in = "speed", damping = {} }}
[outputs]
push = {{ from = "pull + drag", unit = "N" }}
)",
                     stiffness, damping);
}

const char* const kWall = R"(
format = 1
[inputs]
place = { unit = "m" }
[nodes]
stop = { type = "wall", position = "place", stiffness = "40 N/m", at = "5 mm" }
[outputs]
push = { from = "stop", unit = "N" }
)";

struct Conditions {
  double rate = 48000, delay_s = 0.001, mass = 0.05, damping = 0.1;
};

StabilityVerdict analysed(const std::string& text, const Conditions& conditions) {
  const auto graph = parse_graph_leniently(text, "test.toml");
  const auto& table = standard_nodes();
  StabilityOptions options;
  options.world.rate = Hertz{conditions.rate};
  options.world.delay = Seconds{conditions.delay_s};
  options.world.device = {conditions.mass, conditions.damping};
  auto verdict = analyse_stability({nullptr, &graph, &table}, options);
  if (!verdict) throw std::runtime_error(to_string(verdict.error()));
  return *verdict;
}

const RegimeVerdict& regime(const StabilityVerdict& verdict, std::string_view name, bool held) {
  for (const auto& regime : verdict.regimes)
    if (regime.name == name && regime.held == held) return regime;
  throw std::runtime_error("no such regime");
}

/// phi tan phi = x.
double phi(double x) {
  double low = 0, high = std::numbers::pi / 2;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (middle * std::tan(middle) < x ? low : high) = middle;
  }
  return low;
}

}  // namespace

// Gil, Sanchez, Hulin, Preusche & Hirzinger, J. Computing and Information Science in Engineering 9, 2009: K <
// (b + B) / (T/2 + delay), here where (b + B)(T/2 + delay)/m is at most 0.005.
TEST_CASE("stability: the stiffest spring on a delayed device is that of the closed form", "[analysis]") {
  const auto conditions =
      GENERATE(Conditions{48000, 0.001, 0.05, 0.1}, Conditions{1000, 0.001, 0.05, 0.1},
               Conditions{96000, 0.0025, 0.05, 0.1}, Conditions{48000, 0.002, 0.05, 0.05});
  const double delay =
      std::round(conditions.delay_s * conditions.rate) / conditions.rate + 0.5 / conditions.rate;
  const auto verdict = analysed(spring_text(1), conditions);
  const auto& rest = regime(verdict, "at rest", false);
  REQUIRE(rest.stiff.size() == 1);
  const double expected = conditions.damping / delay;
  CHECK(rest.stiff[0].stable_up_to == Approx(expected).epsilon(0.01));
  // A spring without a damper is passive as far as it is stable (Colgate & Schenkel 1997 with a delay).
  REQUIRE(rest.stiff[0].passive_up_to);
  CHECK(*rest.stiff[0].passive_up_to == Approx(expected).epsilon(0.01));
  CHECK(*rest.device_damping == Approx(conditions.damping).epsilon(0.01));
}

// The same device in continuous time: K = (b/tau) phi / sin phi with phi tan phi = b tau / m.
TEST_CASE("stability: with a long delay the stiffest spring is that of phi tan phi", "[analysis]") {
  const double damping = GENERATE(0.25, 1.25, 2.5, 25.0);
  const Conditions conditions{48000, 0.02, 0.05, damping};
  const double delay = conditions.delay_s + 0.5 / conditions.rate, x = damping * delay / conditions.mass;
  const double expected = damping / delay * phi(x) / std::sin(phi(x));
  const auto rest = regime(analysed(spring_text(1), conditions), "at rest", false);
  CHECK(rest.stiff[0].stable_up_to == Approx(expected).epsilon(0.01));
}

// m x'' = F - b x' with the force held for T is, with a = exp(-b T / m), h = (1 - a) m / b and g = T / b - h
// / b:
//   x' = x + h v + g F,   v' = a v + (1 - a) F / b.
// With F = -K x the product of the two roots is 1 at the border: a (1 - K g) + K h (1 - a) / b = 1.
TEST_CASE("stability: the assumed device moves as one that is pushed by a held force", "[analysis]") {
  const auto conditions = GENERATE(Conditions{8000, 0, 0.001, 5}, Conditions{8000, 0, 0.001, 20},
                                   Conditions{1000, 0, 0.01, 1}, Conditions{2000, 0, 0.002, 3});
  const double m = conditions.mass, b = conditions.damping, T = 1.0 / conditions.rate;
  const double a = std::exp(-b * T / m), h = (1 - a) * m / b, g = T / b - h / b;
  const auto rest = regime(analysed(spring_text(1), conditions), "at rest", false);
  REQUIRE(rest.stiff.size() == 1);
  // What grows by less than 1e-4 a second counts as stable.
  CHECK(rest.stiff[0].stable_up_to == Approx((1 - a) / (h * (1 - a) / b - a * g)).epsilon(1e-5));
}

TEST_CASE("stability: a spring below its border holds and one above it grows", "[analysis]") {
  const double border = 0.1 / (0.001 + 0.5 / 48000);
  const auto below = analysed(spring_text(0.97 * border), {}),
             above = analysed(spring_text(1.03 * border), {});
  CHECK(below.stable());
  CHECK(regime(below, "at rest", false).growing == 0);
  CHECK_FALSE(above.stable());
  // A pair of roots, at sqrt(K/m) rad/s, growing by (K tau - b) / 2m.
  const auto& grown = regime(above, "at rest", false);
  CHECK(grown.growing == 2);
  REQUIRE_FALSE(grown.roots.empty());
  CHECK(grown.roots[0].frequency_hz ==
        Approx(std::sqrt(1.03 * border / 0.05) / (2 * std::numbers::pi)).epsilon(0.01));
  CHECK(grown.roots[0].growth_per_s == Approx(0.03 * 0.1 / (2 * 0.05)).epsilon(0.03));
  // In a hand of 2 N s/m the same spring holds.
  CHECK(regime(above, "at rest", true).growing == 0);
}

// The rotor that is assumed has the mass and the damping of the device 10 mm from its axis.
TEST_CASE("stability: a torsion spring on a delayed rotor has the border of a spring on a device",
          "[analysis]") {
  const auto text = [](double stiffness) {
    return fmt::format(
        "format = 1\n[inputs]\nangle = {{ unit = \"rad\" }}\n[nodes]\npull = {{ type = \"spring\", in = "
        "\"angle\", "
        "stiffness = \"{:.17g} N m/rad\", motion = \"rotation\" }}\n[outputs]\nmotor = {{ from = \"pull\", "
        "unit = \"N m\" }}\n",
        stiffness);
  };
  const double border = 1e-4 * 0.1 / (0.001 + 0.5 / 48000);
  const auto below = analysed(text(0.97 * border), {});
  CHECK(below.stable());
  CHECK_FALSE(analysed(text(1.03 * border), {}).stable());
  CHECK(regime(below, "at rest", false).stiff.at(0).with_unit(2) == "2 N m/rad");
  // So are those of the fingertip.
  const double tau = 0.001 + 0.5 / 48000, x = 2.1 * tau / 0.056;
  CHECK(regime(below, "at rest", true).stiff.at(0).stable_up_to ==
        Approx(1e-4 * 2.1 / tau * phi(x) / std::sin(phi(x))).epsilon(0.01));
}

// 1 - g z^-487 + k z^-1 = 0: with k = 1 - g the 243rd partial of the string, where z^-1 is all but -1,
// neither grows nor decays; above it z^487 = g + k. Its resonance is 0.03 Hz wide.
TEST_CASE("stability: a loop through a string that rings for long grows at one of its partials",
          "[analysis]") {
  constexpr double kGain = 0.999, kPeriod = 487;
  const auto with = [&](double share) {
    return analysed(fmt::format(R"(format = 1
[inputs]
x = {{}}
[nodes]
s    = {{ type = "string", in = "x - {:.17g} * back", pitch = "{:.17g} Hz", gain = {}, loss = 0 }}
back = {{ type = "delay", in = "s", time = "1 / system.rate", interpolation = "none" }}
[outputs]
y = {{ from = "s" }}
)",
                                share * (1 - kGain), 48000 / kPeriod, kGain),
                    {});
  };
  CHECK(with(0.97).stable());
  CHECK_FALSE(with(1.03).stable());
}

TEST_CASE("stability: the turns of long delays are counted, or in doubt", "[analysis]") {
  // 1 = g z^-n: every root has the magnitude g^(1/n).
  const auto with = [](double seconds, double gain) {
    return analysed(fmt::format(R"(format = 1
[inputs]
x = {{}}
[nodes]
z = {{ type = "delay", in = "u", time = "{} s", interpolation = "none" }}
u = "x + {} * z"
[outputs]
y = {{ from = "z" }}
)",
                                seconds, gain),
                    {8000, 0, 0.05, 0.1});
  };
  // 3,200 frames; with 80,000 a spectrum of so many points has too few for each turn.
  const auto holds = with(0.4, 0.5);
  CHECK(holds.stable());
  CHECK(holds.doubts.empty());
  CHECK_FALSE(with(0.4, 1.02).stable());
  for (const double gain : {0.5, 1.02}) CHECK(with(10, gain).doubts.size() == 1);
}

TEST_CASE("stability: a wall is analysed as it is touched, bare and held", "[analysis]") {
  const auto verdict = analysed(kWall, {});
  const auto& bare = regime(verdict, "nonlinearities at their largest slope", false);
  const auto& held = regime(verdict, "nonlinearities at their largest slope", true);
  REQUIRE(bare.stiff.size() == 1);
  CHECK(bare.stiff[0].stiffness == Approx(40));
  CHECK(bare.stiff[0].stable_up_to == Approx(0.1 / (0.001 + 0.5 / 48000)).epsilon(0.01));
  // 2.1 N s/m and 56 g: (b tau / m) = 0.038, so phi/sin phi adds 0.6 %.
  const double tau = 0.001 + 0.5 / 48000, x = 2.1 * tau / 0.056;
  CHECK(held.stiff[0].stable_up_to == Approx(2.1 / tau * phi(x) / std::sin(phi(x))).epsilon(0.01));
  CHECK(regime(verdict, "at rest", false).stiff.empty());
}

TEST_CASE("stability: walls at both ends of a range hold what one of them holds", "[analysis]") {
  // 0.1 N s/m and 1.01 ms: 99 N/m each; on the same side of the range they add up.
  const double border = 0.1 / (0.001 + 0.5 / 48000);
  const auto two_walls = [](const char* second) {
    return analysed(fmt::format(R"(
format = 1
[inputs]
place = {{ unit = "m" }}
[nodes]
high = {{ type = "wall", position = "place", stiffness = "80 N/m", at = "5 mm" }}
{}
[outputs]
push = {{ from = "high + low", unit = "N" }}
)",
                                second),
                    {});
  };
  const auto* const mirrored =
      R"(low = "-mirror"
mirror = { type = "wall", position = "-place", stiffness = "80 N/m", at = "5 mm" })";
  const auto* const by_hand = R"x(low = "80 N/m * max(0 m, -place - 5 mm)")x";
  const auto* const second = GENERATE_COPY(as<const char*>{}, mirrored, by_hand);
  const auto ends = two_walls(second);
  CHECK(ends.stable());
  CHECK(regime(ends, "'instrument.high' at its largest slope", false).stiff.at(0).stable_up_to ==
        Approx(border).epsilon(0.01));
  CHECK_FALSE(two_walls(R"(low = { type = "wall", position = "place", stiffness = "80 N/m", at = "4 mm" })")
                  .stable());
}

TEST_CASE("stability: at an unstable equilibrium a law is analysed where it restores", "[analysis]") {
  // Ribs of 8 mm: 4 pi^2 w h / l^2 = 6.17 N/m at most, up and down; the border is 0.1 / tau.
  const auto verdict = analysed(R"(
format = 1
[inputs]
place = { unit = "m" }
[nodes]
ribs = { type = "terrain", position = "place", profile = "sine", weight = "0.1 N", height = "0.1 mm", length = "8 mm" }
[outputs]
push = { from = "ribs", unit = "N" }
)",
                                {});
  CHECK(verdict.stable());
  CHECK(regime(verdict, "at rest", false).unstable_equilibria == std::vector<std::string>{"instrument.ribs"});
  CHECK(regime(verdict, "at rest", false).stiff.empty());
  const auto& steep = regime(verdict, "nonlinearities at their largest slope", false);
  REQUIRE(steep.stiff.size() == 1);
  const double stiffest = 4 * std::pow(std::numbers::pi / 8e-3, 2) * 0.1 * 1e-4;
  CHECK(steep.stiff[0].stiffness == Approx(stiffest).epsilon(1e-6));
  CHECK(steep.stiff[0].stable_up_to == Approx(0.1 / (0.001 + 0.5 / 48000)).epsilon(0.01));
}

TEST_CASE("stability: what pushes away everywhere grows at every delay", "[analysis]") {
  const auto delay = GENERATE(0.0, 0.001, 0.02);
  const auto* const kPushes = R"(
format = 1
[inputs]
place = { unit = "m" }
[outputs]
push = { from = "5 N/m * place", unit = "N" }
)";
  CHECK_FALSE(analysed(kPushes, {.delay_s = delay}).stable());
}

// |x| pushes away on one side whatever its sign; with a spring of more than its slope on no side.
TEST_CASE("stability: an absolute value is analysed on both sides of its corner", "[analysis]") {
  const auto pushed_by = [](const std::string& force) {
    return analysed("format = 1\n[inputs]\nplace = { unit = \"m\" }\n[outputs]\npush = { from = \"" + force +
                        "\", unit = \"N\" }\n",
                    {})
        .stable();
  };
  CHECK_FALSE(pushed_by("5 N/m * abs(place)"));
  CHECK_FALSE(pushed_by("-5 N/m * abs(place)"));
  CHECK(pushed_by("-5 N/m * place - 3 N/m * abs(place)"));
  CHECK(pushed_by("3 N/m * abs(place) - 5 N/m * place"));
  CHECK_FALSE(pushed_by("-3 N/m * place - 5 N/m * abs(place)"));
}

TEST_CASE("stability: a spring behind a dead band of no width has the border of a spring", "[analysis]") {
  // Each corner by itself cancels what passes it: q - clamp(q, 0, 0) has slope 0 while q is between both.
  const auto text = [](double stiffness) {
    return fmt::format(R"toml(
format = 1
[inputs]
place = {{ unit = "m" }}
[nodes]
outside = "place - clamp(place, 0 m, 0 m)"
wanted  = "{} N/m * (max(outside, 0 m) + min(outside, 0 m))"
[outputs]
push = {{ from = "-clamp(wanted, -1 N, 1 N)", unit = "N" }}
)toml",
                       stiffness);
  };
  const Conditions conditions;
  const double border = conditions.damping / (conditions.delay_s + 0.5 / conditions.rate);  // nearly
  CHECK(analysed(text(0.9 * border), conditions).stability == Stability::Stable);
  CHECK(analysed(text(1.1 * border), conditions).stability == Stability::Unstable);
  CHECK(analysed(text(1000 * border), conditions).stability == Stability::Unstable);
}

TEST_CASE("stability: a spring far beyond its border is refused although the drive saturates", "[analysis]") {
  const auto stiffness = GENERATE(200.0, 2e4, 1e9);
  CHECK_FALSE(analysed(fmt::format(R"(
format = 1
[inputs]
place = {{ unit = "m" }}
[nodes]
pull = {{ type = "spring", in = "place", stiffness = {} }}
held = {{ type = "clip", in = "pull", low = "-6 N", high = "6 N" }}
[outputs]
push = {{ from = "held", unit = "N" }}
)",
                                   stiffness),
                       {})
                  .stable());
}

TEST_CASE("stability: an instrument whose outside is not known says so", "[analysis]") {
  const auto verdict = analysed(R"(
format = 1
[inputs]
sensor = {}
[outputs]
drive = { from = "2 * sensor" }
)",
                                {});
  CHECK_FALSE(verdict.outside_known);
  REQUIRE(verdict.open.size() == 1);
  CHECK(verdict.open[0].peak == Approx(2).epsilon(1e-6));
  CHECK(analysed(spring_text(5), {}).outside_known);
}

TEST_CASE("stability: the delay that a spring has room for takes it to its border", "[analysis]") {
  const double stiffness = 50, delay = 0.001 + 0.5 / 48000;
  const auto rest = regime(analysed(spring_text(stiffness), {}), "at rest", false);
  REQUIRE(rest.loops.size() == 1);
  CHECK(rest.loops[0].drive);
  CHECK(rest.loops[0].margin.more_delay_s == Approx(0.1 / stiffness - delay).epsilon(0.01));
}

TEST_CASE("stability: inner loops hold up to exactly the sum of their gains", "[analysis]") {
  // 1 = k (0.5 z^-48 + 0.3 z^-331) first at z = 1; the circle that is looked at is 2e-8 wider.
  const auto verdict = analysed(R"(
format = 1
[inputs]
in = {}
[nodes]
sum  = "in + 0.5 * near + 0.3 * far"
near = { type = "delay", in = "sum", time = "1 ms", interpolation = "none" }
far  = { type = "delay", in = "sum", time = "6.9 ms", interpolation = "none" }
[outputs]
out = { from = "sum" }
)",
                                {});
  CHECK(verdict.stable());
  REQUIRE(verdict.regimes[0].loops.size() == 1);
  const auto& margin = verdict.regimes[0].loops[0].margin;
  CHECK(margin.border == Approx(1 / 0.8).epsilon(1e-5));
  CHECK(margin.border_hz == Approx(0).margin(1e-9));
  CHECK(margin.peak == Approx(0.8).epsilon(1e-5));
  CHECK(std::isinf(margin.more_delay_s));
  // in -> out: 1 / (1 - 0.8) at 0 Hz.
  REQUIRE(verdict.open.size() == 1);
  CHECK(verdict.open[0].peak == Approx(5).epsilon(1e-3));
}

TEST_CASE("stability: a sum that never forgets is no loop that breaks first", "[analysis]") {
  // sum: z / (z - 1); the other loop has a gain of a half.
  const auto verdict = analysed(R"(
format = 1
[inputs]
in = {}
[nodes]
sum    = "0.001 * in + before"
before = { type = "delay", in = "sum", time = "1 / system.rate", interpolation = "none" }
echo   = "in + 0.5 * back"
back   = { type = "delay", in = "echo", time = "1 ms", interpolation = "none" }
[outputs]
out = { from = "sum + echo" }
)",
                                {});
  CHECK(verdict.stable());
  const auto& loops = verdict.regimes[0].loops;
  REQUIRE(loops.size() == 2);
  CHECK(loops[0].integrates() != loops[1].integrates());
  CHECK(describe(verdict)[0].find("margin 6.0 dB") != std::string::npos);
}

TEST_CASE("stability: every root of a loop that is only a delay is counted", "[analysis]") {
  // z^24 = -1.1: 24 roots, all at 24th root of 1.1, at odd multiples of 1 kHz.
  const auto verdict = analysed(R"(
format = 1
[inputs]
in = {}
[nodes]
sum  = "in - 1.1 * back"
back = { type = "delay", in = "sum", time = "0.5 ms", interpolation = "none" }
[outputs]
out = { from = "sum" }
)",
                                {});
  CHECK_FALSE(verdict.stable());
  CHECK(verdict.regimes[0].growing == 24);
  for (const auto& root : verdict.regimes[0].roots) {
    CHECK(root.growth_per_s == Approx(48000 * std::log(1.1) / 24).epsilon(1e-6));
    CHECK(std::fmod(root.frequency_hz / 1000, 2) == Approx(1).epsilon(1e-6));
  }
  CHECK(verdict.regimes[0].loops[0].margin.border == Approx(1 / 1.1).epsilon(1e-6));
}

TEST_CASE("stability: a control that makes a loop grow has a border", "[analysis]") {
  const auto verdict = analysed(R"(
format = 1
[inputs]
in = {}
[controls]
gain = { value = 0.5, range = [0, 2] }
[nodes]
sum  = "in + gain * back"
back = { type = "delay", in = "sum", time = "0.5 ms", interpolation = "none" }
[outputs]
out = { from = "sum" }
)",
                                {});
  REQUIRE(verdict.controls.size() == 1);
  CHECK(verdict.controls[0].stable_low);
  CHECK_FALSE(verdict.controls[0].stable_high);
  REQUIRE(verdict.controls[0].border);
  CHECK(*verdict.controls[0].border == Approx(1).epsilon(1e-3));
}

TEST_CASE("stability: a loop through a threshold is bounded by its hold", "[analysis]") {
  const auto verdict = analysed(R"(
format = 1
[inputs]
place = { unit = "m" }
[nodes]
hit   = { type = "threshold", in = "place", level = "1 mm", hold = "20 ms" }
pulse = { type = "decay", trigger = "hit", time = "5 ms" }
[outputs]
push = { from = "2 N * pulse", unit = "N" }
)",
                                {});
  CHECK(verdict.stable());
  REQUIRE(verdict.events.size() >= 1);
  CHECK(verdict.events[0].path == "instrument.hit");
  CHECK(verdict.events[0].on_loop);
  CHECK(verdict.events[0].hold_s.value() == Approx(0.02));
  CHECK(describe(verdict)[1].find("50 events per second") != std::string::npos);
}

TEST_CASE("stability: the border of a loop that an event may open or close is not run", "[analysis]") {
  const auto with = [](const char* gate) {
    return analysed(fmt::format(R"(
format = 1
[inputs]
place = {{ unit = "m" }}
[nodes]
pull = {{ type = "spring", in = "place", stiffness = "50 N/m" }}
gate = {}
[outputs]
push = {{ from = "pull + 0.001 N * gate", unit = "N" }}
)",
                                gate),
                    {});
  };
  CHECK(border_runs({}, with("\"place / 1 m\"")).size() == 2);
  CHECK(border_runs({}, with(R"x({ type = "threshold", in = "place", level = "1 mm" })x")).empty());
}

TEST_CASE("stability: what a player builds up is no growth, what grows beyond that is", "[analysis]") {
  const auto ended = [](const char* what, double joules, bool grew) {
    ExtremeRun run;
    run.what = what;
    run.energy_after = joules;
    run.grew = grew;
    return run;
  };
  std::vector<ExtremeRun> runs{ended("silence", 1e-3, false), ended("late", 3.9e-3, true),
                               ended("away", 4.1e-3, true)};
  exclude_player_energy(runs);
  CHECK_FALSE(runs[1].grew);
  CHECK(runs[2].grew);
  std::vector<ExtremeRun> wild{ended("silence", 1e-3, true), ended("late", 3.9e-3, true)};
  exclude_player_energy(wild);
  CHECK(wild[1].grew);
}

TEST_CASE("stability: the engine behaves as predicted on both sides of the border", "[analysis]") {
  const auto graph = parse_graph_leniently(spring_text(50), "test.toml");
  const auto& table = standard_nodes();
  const StabilitySubject subject{nullptr, &graph, &table};
  WorldOptions world;
  world.delay = Seconds{0.004};
  const auto verdict = analyse_stability(subject, {.world = world, .hand = {}});
  REQUIRE(verdict);
  const auto runs = border_runs(world, *verdict);
  REQUIRE(runs.size() == 2);
  for (const auto& plan : runs) {
    const auto run = run_extreme(subject, plan);
    REQUIRE(run);
    INFO(run->what << ": " << run->energy_before << " then " << run->energy_after);
    CHECK(run->grew == !plan.expected);
    // From the second to the last quarter, half of the run.
    const double growth = std::log(run->energy_after / run->energy_before) / (plan.seconds / 2);
    const auto& loop = verdict->regimes[0].loops[0];
    CHECK(growth == Approx(plan.expected ? loop.growth_below : loop.growth_above).epsilon(0.1));
  }
}

// The disturbance opens the gate for a quarter of a second: 49 rounds of 5 ms, 1.5^49 = 4e8.
TEST_CASE("stability: the runs find a loop that grows while a gate is open, ahead of the guard",
          "[analysis]") {
  const auto played = [](double gain) {
    const auto graph = parse_graph_leniently(fmt::format(R"(format = 1
[inputs]
in = {{ unit = "full scale" }}
[nodes]
sum  = "in + {} * open * back"
open = {{ type = "adsr", gate = "loud.gate", attack = "1 ms", sustain = 1, release = "20 ms" }}
loud = {{ type = "threshold", in = "in", level = 0.1, hysteresis = 0.05 }}
back = {{ type = "delay", in = "sum", time = "5 ms" }}
[outputs]
out = {{ from = "sum" }}
)",
                                                         gain),
                                             "test.toml");
    const auto run = run_extreme({nullptr, &graph, &standard_nodes()}, {.disturbance = &kDisturbances[2]});
    if (!run) throw std::runtime_error(to_string(run.error()));
    return *run;
  };
  CHECK(played(1.5).exploded);
  CHECK_FALSE(played(1.5).bounded());
  CHECK_FALSE(played(0.9).exploded);
  CHECK(played(0.9).bounded());
}

// A string with feedback over a delayed plant, 1 - g H_LP z^-N - rho H_2LP z^-D = 0 with two DC blockers in
// the outer loop: the gain at which it begins to sing, and where, solved by other means to 1e-6.
TEST_CASE("stability: a delayed string sings at the threshold and the pitch of its least damped root",
          "[analysis]") {
  struct Case {
    double pitch, gain, threshold, hertz;
  };
  const auto c = GENERATE(Case{110, 0.99, 0.028125, 330.0893}, Case{220, 0.99, 0.015189, 439.9039},
                          Case{440, 0.99, 0.012187, 440.3976}, Case{880, 0.9, 0.125075, 889.7818});
  const auto text = fmt::format(R"(
format = 1
[inputs]
in = {{}}
[nodes]
sung  = {{ type = "string", in = "in + 0.005 * late", pitch = {}, gain = {}, loss = 0.5 }}
dark  = {{ type = "low_pass", in = "sung", cutoff = {} }}
ac    = {{ type = "dc_blocker", in = "dark", cutoff = "10 Hz" }}
acdc  = {{ type = "dc_blocker", in = "ac", cutoff = "10 Hz" }}
late  = {{ type = "delay", in = "acdc", time = "20 ms", interpolation = "none" }}
[outputs]
out = {{ from = "sung" }}
)",
                                c.pitch, c.gain, 2 * c.pitch);
  const auto verdict = analysed(text, {.rate = 44100});
  CHECK(verdict.stable());
  REQUIRE(verdict.regimes[0].loops.size() == 1);
  const auto& margin = verdict.regimes[0].loops[0].margin;
  CHECK(0.005 * margin.border == Approx(c.threshold).epsilon(0.01));
  CHECK(margin.border_hz == Approx(c.hertz).margin(0.1));
}
