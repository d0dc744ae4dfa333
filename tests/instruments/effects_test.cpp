#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/study/stability/stability.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/shipped_scene.h"

using namespace tactus;

namespace {

using Values = std::vector<double>;
using Controls = std::map<std::string, ControlValue>;

constexpr double kRate = 48000;

/// The outputs of a part of instruments/effects, in the order of its file; `inputs` likewise.
test::Channels outputs_of(const std::string& file, const Controls& controls, const test::Channels& inputs,
                          int frames) {
  const auto graph = load_graph(test::kInstruments / "effects" / file, test::kInstruments);
  if (!graph) throw std::runtime_error(to_string(graph.error()));
  CompileOptions options;
  options.controls = controls;
  auto plan = compile(**graph, standard_nodes(), options);
  if (!plan) throw std::runtime_error(to_string(plan.error()));
  Player engine{std::move(*plan)};
  return test::run(engine, inputs, frames, {64});
}

/// The forces at these values of the metric, one a frame: the law has no memory.
Values forces(const std::string& file, const Controls& controls, const Values& metric) {
  return outputs_of(file, controls, {metric}, static_cast<int>(metric.size()))[0];
}

/// The forces over time, from the trigger in the first frame on.
Values over_time(const std::string& file, const Controls& controls, int frames) {
  return outputs_of(file, controls, {}, frames)[0];
}

double seconds(std::size_t frame) { return static_cast<double>(frame) / kRate; }

/// Twenty values around a condition of offset o and dead band d that saturates after s, its corners among
/// them.
Values corners(double o, double d, double s) {
  const double e = 1e-6 * s;
  return {o - d - 1.5 * s, o - d - s,      o - d - s + e,  o - d - s - e,
          o - d - 0.1 * s, o - d,          o - d + e,      o,
          o + e,           o - e,          o + d - e,      o + d,
          o + d + 0.1 * s, o + d + s - e,  o + d + s,      o + d + s + e,
          o + d + 2 * s,   o + d + 50 * s, o - d - 50 * s, 0};
}

/// DirectInput's DICONDITION as a force on the device: both sides have a coefficient and a saturation.
double condition(double q, double offset, double dead_band, double coefficient, double strength,
                 double below = 1, double strength_below = 1) {
  double wanted = 0;
  if (q < offset - dead_band) wanted = below * coefficient * (q - (offset - dead_band));
  if (q > offset + dead_band) wanted = coefficient * (q - (offset + dead_band));
  return -std::clamp(wanted, -strength_below * strength, strength);
}

/// Simpson's rule.
double integral(const Values& values, double step) {
  double sum = values.front() + values.back();
  for (std::size_t n = 1; n + 1 < values.size(); ++n) sum += (n % 2 == 1 ? 4 : 2) * values[n];
  return sum * step / 3;
}

Values evenly(double from, double to, int count) {
  Values values(static_cast<std::size_t>(count));
  for (int n = 0; n < count; ++n) values[static_cast<std::size_t>(n)] = from + (to - from) * n / (count - 1);
  return values;
}

void check_equal(const Values& got, const std::function<double(std::size_t)>& law, double tolerance) {
  for (std::size_t n = 0; n < got.size(); ++n) {
    INFO("frame " << n);
    CHECK(got[n] == Approx(law(n)).epsilon(0).margin(tolerance));
  }
}

struct Bumps {
  double strength, spacing, sharpness;

  double angle(double x) const { return 2 * std::numbers::pi * x / spacing; }
  double largest() const {
    const double cosine =
        sharpness == 0 ? 0 : (std::sqrt(1 + 4 * sharpness * sharpness) - 1) / (2 * sharpness);
    return std::sqrt(1 - cosine * cosine) * std::exp(sharpness * (cosine - 1));
  }
  double potential(double x) const {
    const double shape =
        sharpness == 0 ? std::cos(angle(x)) : std::exp(sharpness * (std::cos(angle(x)) - 1)) / sharpness;
    return strength * spacing / (2 * std::numbers::pi * largest()) * shape;
  }
  double force(double x) const {
    return strength / largest() * std::sin(angle(x)) * std::exp(sharpness * (std::cos(angle(x)) - 1));
  }
};

/// A side of a wall: rises with the stiffness, is at most the strength, and falls to 0 at its width.
double slope(double depth, double width, double stiffness, double strength) {
  return std::max(0.0, std::min({stiffness * depth, strength, stiffness * (width - depth)}));
}
double edge(double depth, double width, double crest, double stiffness, double strength) {
  return slope(depth - crest * width, (1 - crest) * width, stiffness, strength) -
         slope(depth, crest * width, stiffness, strength);
}

/// Most energy that a force gives to a point on a path since any earlier time, as the energy watch counts it.
double given(const Values& force, const Values& position) {
  double sum = 0, most = 0;
  for (std::size_t n = 1; n < force.size(); ++n) {
    sum = std::max(0.0, sum + force[n - 1] * (position[n] - position[n - 1]));
    most = std::max(most, sum);
  }
  return most;
}

double peak(const Values& values) {
  double most = 0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

const Values& signal(const SceneRecording& recording, const char* name) {
  return recording.find(name)->samples;
}

}  // namespace

// The condition of the part has a dead band of no width here.
TEST_CASE("effects: a part has the stability margin of its law written inline", "[instruments]") {
  using Laws = std::array<const char*, 4>;  // input, control of the part, node and force inline
  const auto [input, control, node, law] = GENERATE(
      Laws{"position = { unit = \"m\" }", "spring.toml", "", "200 N/m * position"},
      Laws{"velocity = { unit = \"m/s\" }", "damper.toml", "", "2 N s/m * velocity"},
      Laws{"velocity = { unit = \"m/s\" }", "inertia.toml",
           "slope = { type = \"velocity\", in = \"velocity\", cutoff = \"100 Hz\" }", "10 g * slope"});
  const std::string name = std::string{input}.substr(0, std::string{input}.find(' '));
  const auto text = [&](const std::string& nodes) {
    return std::string{"format = 1\n[inputs]\n"} + input + "\n[nodes]\n" + nodes +
           "\n[outputs]\npush = { from = \"force\", unit = \"N\" }\n";
  };
  const auto least_margin = [&](const std::string& nodes) {
    const auto graph = parse_graph_leniently(text(nodes), (test::kInstruments / "mine/test.toml").string(),
                                             test::kInstruments);
    StabilityOptions options;
    options.world.delay = 4_ms;
    const auto verdict = analyse_stability({nullptr, &graph, &standard_nodes()}, options);
    if (!verdict) throw std::runtime_error(to_string(verdict.error()));
    double least = std::numeric_limits<double>::infinity();
    for (const auto& regime : verdict->regimes)
      for (const auto& loop : regime.loops)
        if (!regime.held) least = std::min(least, loop.margin.border);
    CHECK(verdict->regimes.front().loops.size() == 1);  // at rest, too
    return least;
  };
  const auto of_part = least_margin("force = { use = \"../effects/" + std::string{control} + "\", " + name +
                                    " = \"" + name + "\" }");
  const auto of_law = least_margin(std::string{node} + "\nforce = \"-clamp(" + law + ", -2 N, 2 N)\"");
  CHECK(std::isfinite(of_law));
  CHECK(of_part == Approx(of_law).epsilon(1e-6));
}

TEST_CASE("effects: spring and damper follow the law of a condition, corners included", "[instruments]") {
  const double offset = 2e-3, dead_band = 3e-3, stiffness = 500, strength = 1.5;
  const auto x = corners(offset, dead_band, strength / stiffness);
  REQUIRE(x.size() == 20);
  const Controls spring{
      {"offset", offset}, {"dead_band", dead_band}, {"stiffness", stiffness}, {"strength", strength}};
  check_equal(
      forces("spring.toml", spring, x),
      [&](std::size_t n) { return condition(x[n], offset, dead_band, stiffness, strength); }, 1e-12);
  auto uneven = spring;
  uneven["below"] = 0.5;
  uneven["strength_below"] = 0.25;
  check_equal(
      forces("spring.toml", uneven, x),
      [&](std::size_t n) { return condition(x[n], offset, dead_band, stiffness, strength, 0.5, 0.25); },
      1e-12);
  const auto v = corners(0.2, 0.3, strength / 5);
  check_equal(
      forces("damper.toml", {{"offset", 0.2}, {"dead_band", 0.3}, {"damping", 5.0}, {"strength", strength}},
             v),
      [&](std::size_t n) { return condition(v[n], 0.2, 0.3, 5, strength); }, 1e-12);
}

TEST_CASE("effects: inertia resists the filtered acceleration", "[instruments]") {
  Values velocity(4800);
  for (std::size_t n = 0; n < velocity.size(); ++n)
    velocity[n] = 0.5 * std::sin(2 * std::numbers::pi * 10 * seconds(n));
  const auto force =
      forces("inertia.toml", {{"mass", 0.02}, {"cutoff", 1000.0}, {"strength", 20.0}}, velocity);
  const double c = 2 - std::cos(2 * std::numbers::pi * 1000 / kRate), p = c - std::sqrt(c * c - 1);
  double acceleration = 0, before = 0;
  for (std::size_t n = 0; n < velocity.size(); ++n) {
    acceleration = p * acceleration + (1 - p) * kRate * (velocity[n] - before);
    before = velocity[n];
    REQUIRE(force[n] == Approx(-0.02 * acceleration).margin(1e-12));
  }
  // m v 2 pi f, once the filter has settled.
  CHECK(peak({force.begin() + 480, force.end()}) ==
        Approx(0.02 * 0.5 * 2 * std::numbers::pi * 10).epsilon(1e-3));
}

TEST_CASE("effects: a texture is the slope of its height, and its work that of the potential",
          "[instruments]") {
  const double sharpness = GENERATE(0.0, 1.0, 20.0);
  const Bumps bumps{1.5, 4e-3, sharpness};
  const Controls controls{{"strength", 1.5}, {"spacing", 4e-3}, {"sharpness", sharpness}};
  const auto x = evenly(-6e-3, 6e-3, 20);
  const auto force = forces("texture.toml", controls, x);
  check_equal(
      force, [&](std::size_t n) { return bumps.force(x[n]); }, 1e-12);
  const double h = 1e-7;
  check_equal(
      force,
      [&](std::size_t n) { return -(bumps.potential(x[n] + h) - bumps.potential(x[n] - h)) / (2 * h); },
      1e-6 * 1.5);
  // Over four whole bumps, and from the ground to a crest.
  const int count = 20001;
  const auto work = [&](double from, double to) {
    return integral(forces("texture.toml", controls, evenly(from, to, count)), (to - from) / (count - 1));
  };
  CHECK(std::abs(work(-6.5e-3, 9.5e-3)) < 1e-12);
  CHECK(work(-1.5e-3, 0) == Approx(bumps.potential(-1.5e-3) - bumps.potential(0)).epsilon(0).margin(1e-12));
  CHECK(peak(forces("texture.toml", controls, evenly(0, 4e-3, count))) == Approx(1.5).epsilon(1e-6));
}

TEST_CASE("effects: the lines of a grid are the valleys of a sine in each direction", "[instruments]") {
  const auto x = evenly(-12e-3, 12e-3, 20), y = evenly(7e-3, -9e-3, 20);
  const auto force =
      outputs_of("grid.toml", {{"strength", 1.0}, {"spacing_x", 10e-3}, {"spacing_y", 6e-3}}, {x, y}, 20);
  const auto line = [](double place, double spacing) {
    return -std::sin(2 * std::numbers::pi * place / spacing);
  };
  check_equal(
      force[0], [&](std::size_t n) { return line(x[n], 10e-3); }, 1e-12);
  check_equal(
      force[1], [&](std::size_t n) { return line(y[n], 6e-3); }, 1e-12);
}

TEST_CASE("effects: enclosure and ellipse push along their normal, as deep as the device is",
          "[instruments]") {
  const double crest = GENERATE(0.0, 0.5, 1.0);
  const double a = 20e-3, b = 10e-3, width = 20e-3, stiffness = 400, strength = 2;
  const Controls controls{{"half_width", a}, {"half_height", b},       {"width", width},
                          {"crest", crest},  {"stiffness", stiffness}, {"strength", strength},
                          {"centre_x", 2e-3}};
  // A path that crosses the walls everywhere, and the corners.
  Values x, y;
  for (int n = 0; n < 400; ++n) {
    const double turn = 0.1 * n, reach = 50e-3 * std::sqrt(n / 400.0);
    x.push_back(2e-3 + reach * std::cos(turn));
    y.push_back(reach * std::sin(turn));
  }
  for (const double corner : {a, a + width, a + crest * width, -a}) {
    x.push_back(2e-3 + corner);
    y.push_back(0);
  }
  const int frames = static_cast<int>(x.size());
  const auto box = outputs_of("enclosure.toml", controls, {x, y}, frames);
  const auto oval = outputs_of("ellipse.toml", controls, {x, y}, frames);
  for (std::size_t n = 0; n < x.size(); ++n) {
    INFO("at " << x[n] << ", " << y[n]);
    const double across = x[n] - 2e-3;
    const double qx = across - std::clamp(across, -a, a), qy = y[n] - std::clamp(y[n], -b, b);
    const double depth = std::hypot(qx, qy);
    const double push = depth > 0 ? edge(depth, width, crest, stiffness, strength) / depth : 0;
    CHECK(box[0][n] == Approx(push * qx).epsilon(0).margin(1e-12));
    CHECK(box[1][n] == Approx(push * qy).epsilon(0).margin(1e-12));
    const double rho = std::hypot(across / a, y[n] / b);
    const double pull = rho > 0 ? edge((rho - 1) * b, width, crest, stiffness, strength) * b / rho : 0;
    CHECK(oval[0][n] == Approx(pull * across / (a * a)).epsilon(0).margin(1e-12));
    CHECK(oval[1][n] == Approx(pull * y[n] / (b * b)).epsilon(0).margin(1e-12));
  }
}

TEST_CASE("effects: forces of two dimensions do no work on a closed path", "[instruments]") {
  const std::string file = GENERATE("enclosure.toml", "ellipse.toml", "grid.toml");
  const int frames = 96001;
  Values x, y;
  for (int n = 0; n < frames; ++n) {
    const double turn = 2 * std::numbers::pi * n / (frames - 1);
    x.push_back(3e-3 + 27e-3 * std::cos(turn));
    y.push_back(-2e-3 + 22e-3 * std::sin(turn));
  }
  const auto force = outputs_of(file, {}, {x, y}, frames);
  double work = 0, exchanged = 0;
  for (std::size_t n = 1; n < x.size(); ++n) {
    const double step = 0.5 * (force[0][n] + force[0][n - 1]) * (x[n] - x[n - 1]) +
                        0.5 * (force[1][n] + force[1][n - 1]) * (y[n] - y[n - 1]);
    work += step;
    exchanged += std::abs(step);
  }
  CHECK(exchanged > 1e-3);
  CHECK(std::abs(work) < 1e-5 * exchanged);
}

TEST_CASE("effects: the envelope has the integral of its trapezoid, in each repetition", "[instruments]") {
  const double attack = 0.03, fade = 0.04, duration = 0.1, from = 0.25, to = 0.1;
  const auto outputs = outputs_of("envelope.toml",
                                  {{"duration", duration},
                                   {"repeat", 3.0},
                                   {"pause", 0.02},
                                   {"attack", attack},
                                   {"attack_level", from},
                                   {"fade", fade},
                                   {"fade_level", to}},
                                  {}, 24000);
  const auto& level = outputs[0];
  const double area = attack * (from + 1) / 2 + (duration - attack - fade) + fade * (to + 1) / 2;
  for (const int begin : {0, 5760, 11520}) {
    const double sum = std::accumulate(level.begin() + begin, level.begin() + begin + 4800, 0.0);
    CHECK(std::abs(sum - area * kRate) <= 1);
    CHECK(level[static_cast<std::size_t>(begin)] == Approx(from));
    CHECK(level[static_cast<std::size_t>(begin) + 1440] == 1);
    CHECK(level[static_cast<std::size_t>(begin) + 4800] == 0);
  }
  CHECK(peak({level.begin() + 16320, level.end()}) == 0);
}

TEST_CASE("effects: without a duration the envelope does not end", "[instruments]") {
  const auto level = outputs_of("envelope.toml", {{"attack", 0.01}, {"fade", 0.01}}, {}, 9600)[0];
  check_equal(
      level, [](std::size_t n) { return std::min(1.0, seconds(n) / 0.01); }, 1e-12);
}

TEST_CASE("effects: a duration below a frame lasts one frame, and 0 s has no end", "[instruments]") {
  const double duration = GENERATE(1e-6, 5e-6, 0.4 / kRate, 0.6 / kRate, 1.4 / kRate);
  const auto once = outputs_of("envelope.toml", {{"duration", duration}}, {}, 200)[0];
  check_equal(
      once, [](std::size_t n) { return n == 0 ? 1.0 : 0.0; }, 0);
  // Three repetitions follow each other frame by frame.
  const auto thrice = outputs_of("envelope.toml", {{"duration", duration}, {"repeat", 3.0}}, {}, 200)[0];
  check_equal(
      thrice, [](std::size_t n) { return n < 3 ? 1.0 : 0.0; }, 0);
  check_equal(
      outputs_of("envelope.toml", {{"duration", 0.0}}, {}, 200)[0], [](std::size_t) { return 1.0; }, 0);
}

TEST_CASE("effects: the waves of Periodic, with offset, phase and envelope", "[instruments]") {
  using Wave = double (*)(double);
  static constexpr std::array<Wave, 5> kWaves = {
      [](double u) { return std::sin(2 * std::numbers::pi * u); },
      [](double u) { return u < 0.5 ? 1.0 : -1.0; },
      [](double u) { return 1 - 4 * std::abs(u + 0.25 - std::floor(u + 0.25) - 0.5); },
      [](double u) { return 2 * u - 1; }, [](double u) { return 1 - 2 * u; }};
  for (std::size_t shape = 0; shape < kWaves.size(); ++shape) {
    const auto force = over_time("periodic.toml",
                                 {{"shape", static_cast<double>(shape)},
                                  {"frequency", 60.0},
                                  {"strength", 1.5},
                                  {"offset", 0.25},
                                  {"phase", std::numbers::pi / 6}},
                                 9600);
    // Frames on an edge of the wave may fall on either side of it.
    for (std::size_t n = 0; n < force.size(); n += 479) {
      const double turns = 60 * seconds(n) + 1.0 / 12, u = turns - std::floor(turns);
      INFO("shape " << shape << ", frame " << n);
      CHECK(force[n] == Approx(1.5 * kWaves[shape](u) + 0.25).epsilon(0).margin(1e-11));
    }
  }
  const auto twice = over_time("periodic.toml",
                               {{"frequency", 60.0},
                                {"strength", 1.0},
                                {"duration", 0.1},
                                {"repeat", 2.0},
                                {"attack", 0.02},
                                {"fade", 0.03}},
                               12000);
  check_equal(
      twice,
      [](std::size_t n) {
        const double t = seconds(n % 4800);
        if (n >= 9600) return 0.0;
        return std::min({1.0, t / 0.02, (0.1 - t) / 0.03}) * std::sin(2 * std::numbers::pi * 60 * t);
      },
      1e-11);
}

TEST_CASE("effects: constant and ramp", "[instruments]") {
  check_equal(
      over_time("constant.toml", {{"strength", -1.25}}, 20), [](std::size_t) { return -1.25; }, 0);
  check_equal(
      over_time("ramp.toml", {{"strength", 2.0}, {"duration", 0.1}, {"first", -0.5}, {"last", 1.0}}, 9600),
      [](std::size_t n) { return n < 4800 ? 2 * (-0.5 + 1.5 * seconds(n) / 0.1) : 0.0; }, 1e-12);
}

TEST_CASE("effects: a tick is a decaying sine, in proportion to the speed of the impact", "[instruments]") {
  const auto force = forces("tick.toml",
                            {{"trigger", 1.0},
                             {"strength", 3.0},
                             {"full", 0.5},
                             {"frequency", 200.0},
                             {"time", 0.008},
                             {"duration", 0.08},
                             {"fade", 0.005}},
                            Values(4800, 0.3));
  check_equal(
      force,
      [](std::size_t n) {
        const double t = seconds(n), level = std::clamp((0.08 - t) / 0.005, 0.0, 1.0);
        return -level * 3 * 0.6 * std::exp(-t / 0.008) * std::sin(2 * std::numbers::pi * 200 * t);
      },
      1e-11);
}

TEST_CASE("effects: friction is a spring to an anchor that is dragged", "[instruments]") {
  // Out, back, and at rest: the force follows the play operator.
  const Values x{0,      0,    2e-4, 4e-4, 5e-4, 6e-4, 2e-3,  1.8e-3, 1.6e-3, 1.5e-3,
                 1.1e-3, 8e-4, 0,    1e-4, 3e-4, 8e-4, 15e-4, 16e-4,  16e-4,  16e-4};
  const auto force = forces("friction.toml", {{"strength", 1.0}, {"stiffness", 2000.0}}, x);
  double anchor = 0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    anchor = std::clamp(anchor, x[n] - 1.0 / 2000, x[n] + 1.0 / 2000);
    CHECK(force[n] == Approx(-2000 * (x[n] - anchor)).epsilon(0).margin(1e-12));
  }
}

TEST_CASE("effects: sliding friction falls with the speed that it measures itself", "[instruments]") {
  // At 0.1 m/s, twice `speed`, the limit is 0.4 + 0.6 exp(-4) of the strength, once the filter has settled.
  Values x(9600);
  for (std::size_t n = 0; n < x.size(); ++n) x[n] = 0.1 * seconds(n);
  const auto force = forces("friction.toml",
                            {{"strength", 1.0}, {"stiffness", 2000.0}, {"sliding", 0.4}, {"speed", 0.05}}, x);
  CHECK(force.back() == Approx(-(0.4 + 0.6 * std::exp(-4.0))).epsilon(1e-9));
}

TEST_CASE("effects: a recoil has an end, and repetitions are counted in whole numbers", "[instruments]") {
  const auto errors = [](const std::string& fields) {
    const auto graph =
        parse_graph_leniently("format = 1\n[nodes]\nkick = { use = \"../effects/" + fields +
                                  " }\n[outputs]\npush = { from = \"kick\", unit = \"N\" }\n",
                              (test::kInstruments / "mine/test.toml").string(), test::kInstruments);
    const auto plan = compile(graph, standard_nodes(), {});
    return plan ? "" : plan.error().front().where + " " + plan.error().front().what;
  };
  CHECK(errors("recoil.toml\", duration = \"80 ms\", repeat = 2").empty());
  CHECK(errors("recoil.toml\", duration = \"0 s\"").find("test.toml:3:54 'duration' of") !=
        std::string::npos);
  CHECK(errors("constant.toml\", duration = \"1 s\", repeat = 0.6")
            .find("test.toml:3:71 'repeat' of part 'kick' cannot be 0.6") != std::string::npos);
  CHECK(errors("periodic.toml\", shape = 1.5").find("cannot be 1.5") != std::string::npos);
}

TEST_CASE("effects: friction does not creep under a load that swings, and gives no energy", "[instruments]") {
  // A device of which the load never exceeds the limit: its positions swing within the reach of the anchor.
  Values swinging(96000), wandering(96000);
  double place = 0;
  for (std::size_t n = 0; n < swinging.size(); ++n) {
    const double t = seconds(n);
    swinging[n] = 2e-4 + 2.9e-4 * std::sin(2 * std::numbers::pi * 7 * t);
    place += 1e-6 * std::sin(2 * std::numbers::pi * 1.3 * t) * (1 + std::sin(2 * std::numbers::pi * 17 * t));
    wandering[n] = place;
  }
  const Controls controls{{"strength", 1.0}, {"stiffness", 2000.0}};
  const auto held = forces("friction.toml", controls, swinging);
  for (std::size_t n = 0; n < held.size(); n += 97)
    REQUIRE(held[n] == Approx(-2000 * (swinging[n] - swinging[0])).epsilon(0).margin(1e-12));
  CHECK(given(forces("friction.toml", controls, wandering), wandering) <= 1.01 * 1.0 / (2 * 2000));
}

TEST_CASE("effects: friction begins without a force, wherever the device is", "[instruments]") {
  const Controls controls{{"strength", 1.0}, {"stiffness", 2000.0}};
  for (const double place : {-0.3, 0.012, 0.05})
    for (const double force : forces("friction.toml", controls, Values(100, place))) REQUIRE(force == 0.0);
  // Each of two repetitions of 2 ms, 96 frames, begins at its own place.
  Values sliding(192);
  for (std::size_t n = 0; n < sliding.size(); ++n) sliding[n] = 1e-5 * static_cast<double>(n);
  auto twice = controls;
  twice.insert({{"duration", 0.002}, {"repeat", 2.0}});
  const auto force = forces("friction.toml", twice, sliding);
  for (const std::size_t start : {0u, 96u})
    for (std::size_t n = 0; n < 40; ++n)  // before it slides, after 0.5 mm
      CHECK(force[start + n] == Approx(-2000 * 1e-5 * static_cast<double>(n)).epsilon(0).margin(1e-12));
}

TEST_CASE("effects: passive effects give no more than they store, and friction holds an arm",
          "[instruments]") {
  for (const char* name : {"spring", "texture", "damper", "inertia", "friction", "friction_again"}) {
    INFO(name);
    const auto played = test::play(std::string{"effects/arm/"} + name + ".toml");
    CHECK_FALSE(played.recording.ports.front().active_at_s);
  }
  for (const char* name : {"enclosure", "ellipse", "grid"}) {
    INFO(name);
    const auto played = test::play(std::string{"effects/plane/"} + name + ".toml");
    CHECK_FALSE(played.recording.ports.front().active_at_s);
  }
  const auto friction = test::play("effects/arm/friction.toml").recording;
  const auto& arm = signal(friction, "plant.arm");
  const auto at = [&](double time) { return arm[static_cast<std::size_t>(time * 20000)]; };
  // 0.7 N at 2 kN/m, for as long as it pushes, less than a count of the encoder apart.
  CHECK(at(0.5) == Approx(0.35e-3).epsilon(0.01));
  CHECK(std::abs(at(1.1) - at(0.5)) < 2e-6);
  CHECK(std::abs(at(2.4) - at(1.7)) < 2e-6);
}

TEST_CASE("effects: friction starts at 30 mm and again elsewhere, both times without a force",
          "[instruments]") {
  const auto again = test::play("effects/arm/friction_again.toml").recording;
  const auto at = [&](const char* name, double time) {
    return signal(again, name)[static_cast<std::size_t>(std::lround(time * 20000))];
  };
  for (const double time : {0.2, 0.25, 1.8, 1.85}) CHECK(std::abs(at("plant.motor", time)) < 4e-3);
  CHECK(at("plant.arm", 0.29) == Approx(30e-3));
  CHECK(at("plant.arm", 0.29) - at("plant.arm", 1.85) > 10e-3);
  // 0.7 N at 2 kN/m from where it started, to either side.
  CHECK(at("plant.arm", 0.6) - at("plant.arm", 0.29) == Approx(0.35e-3).epsilon(0.01));
  CHECK(at("plant.arm", 2.4) - at("plant.arm", 1.85) == Approx(-0.35e-3).epsilon(0.01));
}

TEST_CASE("effects: friction in repetitions gives way by the force over the stiffness, and gives no energy",
          "[instruments]") {
  SceneOptions repeated;
  repeated.set = {{"duration", 0.1}, {"repeat", 0.0}};
  const auto played = test::play("effects/arm/friction.toml", repeated).recording;
  const auto& arm = signal(played, "plant.arm");
  // The force drops to 0 every 100 ms. From 0.25 s to 1.05 s the load is 0.7 N: eight times 0.35 mm, and what
  // the arm slides while it swings. Undamped it would swing by X with 0.7 N X = (1 N)^2 / (2 2 kN/m) + 1 N (X
  // - 0.5 mm): 0.833 mm, which leaves the anchor 0.333 mm further on.
  const double moved = arm[21000] - arm[5000];
  CHECK(moved > 8 * 0.35e-3);
  CHECK(moved < 8 * (0.333e-3 + 0.35e-3));
  CHECK_FALSE(played.ports.front().active_at_s);
}

TEST_CASE("effects: a tick doubles the peak acceleration of a wall, and is as deep", "[instruments]") {
  SceneOptions plain;
  plain.set = {{"tick", 0.0}};
  const auto with = test::play("effects/arm/hard_wall.toml").recording;
  const auto without = test::play("effects/arm/hard_wall.toml", plain).recording;
  CHECK(peak(signal(with, "judge.whole")) == Approx(76.4).epsilon(0.02));
  CHECK(peak(signal(without, "judge.whole")) == Approx(32.9).epsilon(0.02));
  const auto rms = [](const Values& values) {
    return std::sqrt(
        std::inner_product(values.begin() + 4000, values.begin() + 10000, values.begin() + 4000, 0.0) / 6000);
  };
  CHECK(rms(signal(with, "judge.high")) > 5 * rms(signal(without, "judge.high")));
  const auto depth = [](const Values& arm) { return *std::max_element(arm.begin(), arm.begin() + 10000); };
  CHECK(depth(signal(with, "plant.arm")) == Approx(depth(signal(without, "plant.arm"))).epsilon(0.01));
}
