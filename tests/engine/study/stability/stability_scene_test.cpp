#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/nodes/table.h"
#include "engine/study/stability/stability_check.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;

namespace {

/// A heavy lever that a coil moves, against a stop, and a spring by feedback.
struct LeverFolder : test::TemporaryFolder {
  LeverFolder() {
    write("plant.toml", R"(format = 1
[inputs]
drive = { unit = "full scale" }
[networks.arm]
frame   = { type = "ground" }
lever   = { type = "mass", mass = "1 kg" }
bearing = { type = "damper", between = ["frame", "lever"], damping = "0.5 N s/m" }
stop    = { type = "contact", between = ["lever", "frame"], stiffness = "1e5 N/m", exponent = 1, offset = "-5 mm" }
motor   = { type = "coil", on = "lever", voltage = "1 V * drive", force_factor = "2 T m", resistance = "4 ohm", inductance = "0 H" }
[outputs]
place = { from = "arm.lever.position", unit = "m" }
)");
    write("instrument.toml", R"(format = 1
[inputs]
place = { unit = "m" }
[nodes]
pull = { type = "spring", in = "place", stiffness = "100 N/m" }
[outputs]
motor = { from = "pull / 1 N" }
)");
    write("scene.toml", R"(format = 1
delay = "2 ms"
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", place = "plant.place" }
plant = { use = "plant.toml", drive = "instrument.motor" }
)");
  }
};

/// A string whose sound a shaker turns into what its piezo reads.
struct StringFolder : test::TemporaryFolder {
  StringFolder() {
    write("scene.toml", R"(format = 1
delay = "5 ms"
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", piezo = "plant.piezo" }
plant = { use = "plant.toml", drive = "instrument.shaker" }
)");
  }
};

/// What `judge`, such as analyse_stability, says of the scene of a folder.
auto judged(const test::TemporaryFolder& folder, const auto& judge) {
  const auto scene = load_scene_leniently(folder.path() / "scene.toml");
  StabilityOptions options;
  options.world.delay = scene.scene->delay;
  return judge(StabilitySubject{&scene, nullptr, &standard_nodes()}, options);
}

StabilityVerdict analysed(const test::TemporaryFolder& folder) {
  auto verdict = judged(
      folder, [](const auto& scene, const auto& options) { return analyse_stability(scene, options); });
  if (!verdict) throw std::runtime_error(to_string(verdict.error()));
  return *verdict;
}

const RegimeVerdict* find_regime(const StabilityVerdict& verdict, std::string_view name, bool held) {
  for (const auto& regime : verdict.regimes)
    if (regime.name == name && regime.held == held) return &regime;
  return nullptr;
}

}  // namespace

// A string at 110 Hz whose second partial is the first to grow, by 0.5 % a second 2 % above the border; the
// others decay as slowly.
TEST_CASE("stability: a partial that grows below others that decay is found in the run", "[analysis]") {
  const StringFolder folder;
  folder.write("instrument.toml", R"(format = 1
[inputs]
piezo = { unit = "full scale" }
[nodes]
clean  = { type = "dc_blocker", in = "piezo", cutoff = "30 Hz" }
string = { type = "string", in = "0.25 * clean", pitch = "110 Hz", gain = 0.996, loss = 0.3 }
felt   = { type = "high_pass", in = "string", cutoff = "40 Hz" }
[outputs]
shaker = { from = "0.3 * felt" }
)");
  folder.write("plant.toml", R"(format = 1
[inputs]
drive = { unit = "full scale" }
[outputs]
piezo = { from = "0.02 * drive" }
)");
  const auto report = judged(
      folder, [](const auto& scene, const auto& options) { return check_stability(scene, options, false); });
  REQUIRE(report);
  CHECK(report->stability() == Stability::Stable);
  const auto above = std::ranges::find(report->runs, false, &ExtremeRun::expected);
  REQUIRE(above != report->runs.end());
  CHECK(above->grew);
  // From the second to the last quarter the mode grows for half of the run.
  const auto& loop = report->verdict.regimes.front().loops.front();
  CHECK(std::log(above->energy_after / above->energy_before) ==
        Approx(loop.growth_above * above->seconds / 2).epsilon(0.05));
}

// Partials 0.2 Hz wide, between which the loop gives next to nothing. Left alone for 40 s after a push, the
// second one grows by 0.051/s at 0.2 and by 0.203/s at 0.25, so that it neither grows nor decays at 0.183.
TEST_CASE("stability: the narrow resonances of a string behind a mass are not overlooked", "[analysis]") {
  const StringFolder folder;
  folder.write("plant.toml", R"(format = 1
[inputs]
drive = { unit = "full scale" }
[networks.stick]
stick  = { type = "oscillator", mass = "50 g", frequency = "60 Hz", damping_ratio = 0.2 }
shaker = { type = "force", on = "stick", force = "3 N * drive" }
[nodes]
shake  = { type = "difference", in = "stick.stick.velocity" }
[outputs]
piezo = { from = "0.0005 / 1 m/s^2 * shake" }
)");
  const auto verdict = [&](double felt) {
    folder.write("instrument.toml", fmt::format(R"(format = 1
[inputs]
piezo = {{ unit = "full scale" }}
[nodes]
s = {{ type = "string", in = "piezo", pitch = "110 Hz", gain = 0.995, loss = 0.4 }}
[outputs]
shaker = {{ from = "{} * s" }}
)",
                                                felt));
    return analysed(folder);
  };
  const auto below = verdict(0.17);
  CHECK(below.stable());
  CHECK(0.17 * below.regimes.front().loops.front().margin.border == Approx(0.1834).epsilon(0.002));
  for (const auto& [felt, growth] : {std::pair{0.2, 0.051}, std::pair{0.25, 0.203}}) {
    const auto above = verdict(felt);
    CHECK_FALSE(above.stable());
    REQUIRE_FALSE(above.regimes.front().roots.empty());
    CHECK(above.regimes.front().roots.front().growth_per_s == Approx(growth).epsilon(0.02));
  }
}

// The coil turns the volt of the spring into Bl / R = 0.5 N, and brakes by Bl^2 / R = 1 N s/m.
TEST_CASE("stability: a scene is judged with its own plant, ring and coil", "[analysis]") {
  const LeverFolder folder;
  const auto verdict = analysed(folder);
  CHECK(verdict.stable());
  CHECK(verdict.delay_s == Approx(0.002));
  const auto* bare = find_regime(verdict, "at rest", false);
  REQUIRE(bare != nullptr);
  REQUIRE(bare->stiff.size() == 1);
  const double delay = 0.002 + 0.5 / 48000, damping = 1.5;
  CHECK(*bare->device_damping == Approx(damping).epsilon(0.01));
  CHECK(bare->stiff[0].stable_up_to == Approx(damping / delay / 0.5).epsilon(0.01));
  CHECK(*bare->stiff[0].passive_up_to == Approx(damping / delay / 0.5).epsilon(0.01));
  // A fingertip adds its 2 N s/m.
  const auto* held = find_regime(verdict, "at rest", true);
  REQUIRE(held != nullptr);
  CHECK(*held->device_damping == Approx(damping + 2).epsilon(0.01));
  CHECK(held->stiff[0].stable_up_to == Approx((damping + 2) / delay / 0.5).epsilon(0.01));
}

TEST_CASE("stability: against its stop a lever rings, and the delay turns a spring into an engine there",
          "[analysis]") {
  const LeverFolder folder;
  const auto verdict = analysed(folder);
  const auto* closed = find_regime(verdict, "stop closed", false);
  REQUIRE(closed != nullptr);
  // The stop holds the lever at w = sqrt(1e5 N/m / 1 kg), 50.3 Hz. A weak spring K with a delay tau brakes it
  // by -K sin(w tau) / w, so the damping of 1.5 N s/m is used up at K = 1.5 w / sin(w tau), half of which the
  // coil gives.
  const double w = std::sqrt(1e5), delay = 0.002 + 0.5 / 48000;
  CHECK(closed->stiff[0].stable_up_to == Approx(1.5 * w / std::sin(w * delay) / 0.5).epsilon(0.02));
  // The spring of the file, 50 N/m at the lever: growth (50 sin(w tau) / w - 1.5) / 2.
  const double growth = (50 * std::sin(w * delay) / w - 1.5) / 2;
  bool found = false;
  for (const auto& root : closed->roots)
    found = found ||
            (std::abs(root.frequency_hz - 50.33) < 0.1 && root.growth_per_s == Approx(growth).epsilon(0.02));
  CHECK(found);
}

// The border of the first test: 1.5 N s/m / 2.01 ms / 0.5 N/V.
TEST_CASE("stability: a scene is analysed at the lowest and highest values that gestures give to controls",
          "[analysis]") {
  const LeverFolder folder;
  folder.write("instrument.toml", R"(format = 1
[inputs]
place = { unit = "m" }
[controls]
stiffness = { value = "100 N/m", range = ["0 N/m", "9000 N/m"] }
share = { value = 1, range = [0, 1] }
[nodes]
pull = { type = "spring", in = "place", stiffness = "stiffness * share" }
[outputs]
motor = { from = "pull / 1 N" }
)");
  const double border = 1.5 / (0.002 + 0.5 / 48000) / 0.5;
  const auto with_gestures = [&](const std::string& gestures) {
    folder.write("scene.toml", R"(format = 1
delay = "2 ms"
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", place = "plant.place", stiffness = "harder", share = "less" }
plant = { use = "plant.toml", drive = "instrument.motor" }
[gestures]
)" + gestures);
    return analysed(folder);
  };
  const auto played = [&](double highest, double share_then) {
    return with_gestures(fmt::format(
        R"(harder = {{ points = [["0.2 s", "100 N/m"], ["0.4 s", "{:.9g} N/m"], ["0.6 s", "100 N/m"]] }}
less = {{ points = [["0 s", 1], ["0.1 s", {:.9g}], ["0.7 s", {:.9g}], ["0.8 s", 1]] }}
)",
        highest, share_then, share_then));
  };
  CHECK(played(0.98 * border, 1.0).stable());
  CHECK(played(1.96 * border, 0.5).stable());
  const auto beyond = played(2.04 * border, 0.5);
  CHECK_FALSE(beyond.stable());
  for (const auto& reached : beyond.gestures) {
    CAPTURE(reached.control, reached.value);
    const bool highest = reached.value > border;
    CHECK((reached.stability == Stability::Stable) == !highest);
    if (highest) CHECK(reached.seconds == Approx(0.4));
  }
  CHECK(beyond.gestures.size() == 4);  // the lowest and highest of both

  // Where both move, each in frames of its own: the product is largest between their ends.
  const auto crossing = [&](double most) {
    return with_gestures(fmt::format(R"(harder = {{ points = [["0.1 s", "0 N/m"], ["0.9 s", "{:.9g} N/m"]] }}
less = {{ points = [["0.10013 s", 1], ["0.90013 s", 0]] }}
)",
                                     4.0 * most));
  };
  CHECK(crossing(0.98 * border).stable());
  const auto crossed = crossing(1.02 * border);
  CHECK_FALSE(crossed.stable());
  REQUIRE_FALSE(crossed.gestures.empty());
  CHECK(crossed.gestures.back().stability == Stability::Unstable);
  CHECK(crossed.gestures.back().seconds == Approx(0.5).margin(0.06));  // 1 - (2 t / 0.8 s)^2 above 0.98
}

// Until it moves, what a spring is anchored to is a fixed place: the border is that of a spring alone.
TEST_CASE("stability: a spring to an anchor that stays behind is a spring", "[analysis]") {
  const LeverFolder folder;
  const double border = 1.5 / (0.002 + 0.5 / 48000) / 0.5;
  const auto verdict = [&](const std::string& anchor, double stiffness) {
    folder.write("instrument.toml", fmt::format(R"--(format = 1
[inputs]
place = {{ unit = "m" }}
[nodes]
anchor = {}
pull = "-{:.9g} N/m * (place - anchor)"
[outputs]
motor = {{ from = "pull / 1 N" }}
)--",
                                                anchor, stiffness));
    return analysed(folder).stability;
  };
  constexpr const char* kBacklash = R"({ type = "hysteresis", in = "place", width = "2 mm" })";
  CHECK(verdict(kBacklash, 0.98 * border) == Stability::Stable);
  CHECK(verdict(kBacklash, 1.02 * border) == Stability::Unstable);
  // When it is taken anew the check cannot know.
  constexpr const char* kState =
      R"({ type = "state", in = "place", trigger = "abs(place - anchor) > 1 mm" })";
  CHECK(verdict(kState, 0.98 * border) == Stability::Undecided);
  CHECK(verdict(kState, 1.02 * border) == Stability::Unstable);
}

// The force k x^2 / 10 mm has the stiffness 2 k x / 10 mm, up to 2 k at 10 mm, and k beyond. Where the scene
// begins it is 0, and at the 0.1 m and 1 m that are tried anyway it is k. The border is that of the first
// test.
TEST_CASE("stability: a gain that depends on the place is judged where the scene takes it", "[analysis]") {
  const LeverFolder folder;
  const double border = 1.5 / (0.002 + 0.5 / 48000) / 0.5;
  const auto verdict = [&](double share) {
    folder.write("instrument.toml", fmt::format(R"--(format = 1
[inputs]
place = {{ unit = "m" }}
[controls]
k = {{ value = "{:.9g} N/m", range = ["0 N/m", "9000 N/m"] }}
[nodes]
pull = "-1 * k * clamp(place / 10 mm, 0, 1) * place"
[outputs]
motor = {{ from = "pull / 1 N" }}
)--",
                                                share * border));
    folder.write("plant.toml", R"(format = 1
[inputs]
drive = { unit = "full scale" }
hand = { unit = "N" }
[networks.arm]
frame   = { type = "ground" }
lever   = { type = "mass", mass = "1 kg" }
bearing = { type = "damper", between = ["frame", "lever"], damping = "0.5 N s/m" }
motor   = { type = "coil", on = "lever", voltage = "1 V * drive", force_factor = "2 T m", resistance = "4 ohm", inductance = "0 H" }
push    = { type = "force", on = "lever", force = "hand" }
[outputs]
place = { from = "arm.lever.position", unit = "m" }
)");
    folder.write("scene.toml", R"(format = 1
delay = "2 ms"
duration = "4 s"
[parts]
instrument = { use = "instrument.toml", place = "plant.place" }
plant = { use = "plant.toml", drive = "instrument.motor", hand = "push" }
[gestures]
push = { points = [["0 s", "3 N"]] }
)");
    return analysed(folder);
  };
  const auto soft = verdict(0.45), stiff = verdict(0.8);
  CHECK(soft.stability == Stability::Stable);
  CHECK(stiff.stability == Stability::Unstable);
  CHECK(std::ranges::any_of(
      stiff.held, [](const auto& held) { return held.place && held.stability == Stability::Unstable; }));
}

// A recursion x -> a x at each trigger grows for a > 1, however often it is triggered.
TEST_CASE("stability: a state that computes itself is judged by its own recursion", "[analysis]") {
  const LeverFolder folder;
  const auto verdict = [&](double gain) {
    folder.write("instrument.toml", fmt::format(R"(format = 1
[inputs]
place = {{ unit = "m" }}
[nodes]
hit  = {{ type = "threshold", in = "place / 1 m", level = 0.001, hold = "20 ms" }}
sum  = {{ type = "state", in = "{:.9g} * sum + place / 1 m", trigger = "hit" }}
[outputs]
motor = {{ from = "0.001 * hit" }}
sound = {{ from = "sum", kind = "audio" }}
)",
                                                gain));
    return analysed(folder).stability;
  };
  CHECK(verdict(0.98) == Stability::Stable);
  CHECK(verdict(1.02) == Stability::Unstable);
}

TEST_CASE("stability: explicit contacts too short for the rate are refused, with the steps that they need",
          "[analysis]") {
  // A gram on 4e6 N/m touches for pi sqrt(m / K) = 49.7 us, 2.4 steps at 48 kHz: fewer than 5.
  const auto text = [](const char* solver) {
    return fmt::format(R"(format = 1
[networks.n]
solver = "{}"
frame = {{ type = "ground" }}
ball  = {{ type = "mass", mass = "1 g", at = "-1 mm", velocity = "1 m/s" }}
wall  = {{ type = "contact", between = ["ball", "frame"], stiffness = "4e6 N/m", exponent = 1 }}
[outputs]
ball = {{ from = "n.ball.position", unit = "m" }}
)",
                       solver);
  };
  const auto verdict_of = [&](const char* solver) {
    const auto graph = parse_graph_leniently(text(solver), "plant.toml");
    auto verdict = analyse_stability({nullptr, &graph, &standard_nodes()}, {});
    REQUIRE(verdict);
    return *verdict;
  };
  const auto refused = verdict_of("explicit");
  CHECK_FALSE(refused.stable());
  REQUIRE_FALSE(refused.networks.empty());
  CHECK(refused.networks[0].contact_steps ==
        Approx(std::numbers::pi * std::sqrt(1e-3 / 4e6) * 48000).epsilon(0.01));
  CHECK(verdict_of("passive").stable());
}

TEST_CASE("check: what creeps away from a held place is stable only if it does not grow farther out",
          "[study]") {
  // m x'' + b x' = f(x) grows at 0 Hz where f' > 0: with x^3 at every place but 0, with x^3 - x^5 only up to
  // 0.77 m; from there it comes to rest at 1 m.
  const auto [force, expected] = GENERATE(table<std::string, Stability>(
      {{"u * u * u", Stability::Unstable}, {"u * u * u - u * u * u * u * u", Stability::Stable}}));
  INFO(force);
  test::TemporaryFolder folder;
  folder.write("plant.toml", R"(format = 1
[inputs]
drive = { unit = "full scale" }
[networks.device]
frame = { type = "ground" }
tip   = { type = "mass", mass = "50 g" }
drag  = { type = "damper", between = ["frame", "tip"], damping = "0.5 N s/m" }
push  = { type = "force", on = "tip", force = "drive * 1 N" }
[outputs]
place = { from = "device.tip.position", unit = "m" }
)");
  folder.write("instrument.toml",
               "format = 1\n[inputs]\nplace = { unit = \"m\" }\n[nodes]\nu = \"place / 1 m\"\n[outputs]\n"
               "motor = { from = \"" +
                   force + "\" }\n");
  folder.write("scene.toml", R"(format = 1
duration = "1 s"
[parts]
instrument = { use = "instrument.toml", place = "plant.place" }
plant = { use = "plant.toml", drive = "instrument.motor" }
)");
  CHECK(analysed(folder).stability == expected);
}
