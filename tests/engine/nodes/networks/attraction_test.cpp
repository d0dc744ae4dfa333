#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "engine/nodes/networks/network.h"
#include "engine/physics/linearised.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/parse_graph.h"

using namespace tactus;
using namespace tactus::test;

namespace {

using Samples = std::vector<double>;

// strength F, reach r:  F(d) = F x (3 / (2 + x^2))^1.5,  x = d / r;  V = -E / w,  w = sqrt(1 + x^2 / 2)
constexpr double kStrength = 2.0, kReach = 3e-3, kMass = 0.0125;

double force(double d) {
  const double x = d / kReach;
  return kStrength * x * std::pow(3.0 / (2.0 + x * x), 1.5);
}
double slope(double d) { return (force(d + 1e-7) - force(d - 1e-7)) / 2e-7; }
double potential(double d) {
  const double w = std::sqrt(1.0 + 0.5 * (d / kReach) * (d / kReach));
  return -0.5 * std::sqrt(27.0) * std::numbers::sqrt2 * kReach * kStrength / w;
}

/// The zero of a falling or rising function between two places.
template <class F>
double zero(F f, double low, double high) {
  const bool rises = f(high) > 0.0;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    ((f(middle) > 0.0) == rises ? high : low) = middle;
  }
  return low;
}

const std::string kMagnet =
    "base = { type = \"ground\" }\nmagnet = { type = \"attraction\", between = [\"base\", \"stick\"], "
    "strength = \"2 N\", reach = \"3 mm\" }\n";

std::string stick(double at) {
  return "stick = { type = \"mass\", mass = \"12.5 g\", at = " + std::to_string(at) + " }\n";
}
std::string held(double stiffness, const std::string& frame) {
  return frame + "\nspring = { type = \"spring\", between = [\"stick\", \"frame\"], stiffness = " +
         std::to_string(stiffness) + ", damping = 0.8 }\n";
}
std::string solved(const std::string& solver) { return "solver = \"" + solver + "\"\n"; }

std::string graph(const std::string& network, const std::string& outputs) {
  return "format = 1\nname = \"n\"\n[inputs]\nplace = {}\n[networks.n]\n" + network + "[outputs]\n" + outputs;
}
Samples play(const std::string& network, const std::string& output, const Samples& place) {
  return run(*engine_of(graph(network, "out = { from = \"" + output + "\" }\n")), {place},
             static_cast<int>(place.size()), {64})[0];
}

}  // namespace

TEST_CASE("attraction: it is in equilibrium with a spring where both forces are equal", "[physics]") {
  const std::string solver = GENERATE("passive", "explicit", "implicit", "exact", "auto");
  // Stiffer than the steepest fall of the force: one place only.
  const double stiffness = 1000.0, frame = 6e-3;
  const double at = zero([&](double d) { return force(d) - stiffness * (frame - d); }, 0.0, frame);
  const auto network = solved(solver) + kMagnet + stick(frame) +
                       held(stiffness, "frame = { type = \"ground\", at = \"6 mm\" }");
  const Samples rest(48000, 0.0);
  CHECK(play(network, "n.stick / 1 m", rest).back() == Approx(at).epsilon(1e-9));
  CHECK(play(network, "n.magnet / 1 N", rest).back() == Approx(force(at)).epsilon(1e-9));
  CHECK(play(network, "n.magnet.distance / 1 m", rest).back() == Approx(at).epsilon(1e-9));
}

TEST_CASE("attraction: a stick on a soft spring snaps in and out at the critical gaps", "[physics]") {
  const std::string solver = GENERATE("passive", "explicit", "implicit", "exact");
  // Two places are left where -F' = k; between them none is stable. F falls most at x = sqrt(3).
  const double stiffness = 150.0, steepest = std::sqrt(3.0) * kReach;
  REQUIRE(-slope(steepest) > stiffness);
  const auto critical = [&](double from, double to) {
    const double d = zero([&](double x) { return slope(x) + stiffness; }, from, to);
    return d + force(d) / stiffness;
  };
  const double snaps_in = critical(steepest, 10 * kReach), snaps_out = critical(kReach, steepest);
  REQUIRE(snaps_in < snaps_out);
  const auto network = solved(solver) + kMagnet + stick(0.02) +
                       held(stiffness, "frame = { type = \"motion\", position = \"1 m * place\" }");
  const int frames = 4 * 48000;
  const double far = 0.02, near = 0.012;
  Samples place(2 * frames);
  for (int n = 0; n < frames; ++n) {
    place[std::size_t(n)] = far + (near - far) * n / frames;
    place[std::size_t(frames + n)] = near + (far - near) * n / frames;
  }
  const auto at = play(network, "n.stick / 1 m", place);
  const auto in = std::find_if(at.begin(), at.end(), [](double x) { return x < 1.5 * kReach; });
  const auto out = std::find_if(in + frames / 2, at.end(), [&](double x) { return x > 3.0 * kReach; });
  REQUIRE(out != at.end());
  CHECK(place[std::size_t(in - at.begin())] == Approx(snaps_in).epsilon(0.03));
  CHECK(place[std::size_t(out - at.begin())] == Approx(snaps_out).epsilon(0.03));
}

TEST_CASE("attraction: a stick that swings through it keeps its energy", "[physics]") {
  const std::string solver = GENERATE("passive", "implicit", "exact");
  const double at = GENERATE(1e-4, 3e-3, 2e-2);
  CAPTURE(solver, at);
  const auto energy = play(solved(solver) + kMagnet + stick(at), "n.energy / 1 J", Samples(480'000, 0.0));
  const double stored = potential(at) - potential(0.0);
  // Where springs are centred the first energy is that of half a step before the start.
  CHECK(energy.front() == Approx(stored).epsilon(1e-3));
  double worst = 0.0;
  for (const double e : energy) worst = std::max(worst, std::abs(e / energy.front() - 1.0));
  CHECK(worst < 1e-10);
}

TEST_CASE("attraction: it gives a stick the speed and the frequency of its potential", "[physics]") {
  const std::string solver = GENERATE("passive", "explicit", "implicit", "exact", "reference");
  CAPTURE(solver);
  const auto speed = play(solved(solver) + kMagnet + stick(0.02), "n.stick.velocity / 1 m/s",
                          Samples(solver == "reference" ? 4800 : 48000, 0.0));
  const double fastest = *std::max_element(speed.begin(), speed.end(),
                                           [](double a, double b) { return std::abs(a) < std::abs(b); });
  CHECK(std::abs(fastest) ==
        Approx(std::sqrt(2.0 * (potential(0.02) - potential(0.0)) / kMass)).epsilon(1e-3));
  const auto swing = play(solved(solver) + kMagnet + stick(kReach / 100), "n.stick / 1 m",
                          Samples(solver == "reference" ? 4800 : 48000, 0.0));
  std::vector<double> passages;
  for (std::size_t n = 1; n < swing.size(); ++n)
    if (swing[n - 1] < 0.0 && swing[n] >= 0.0)
      passages.push_back(static_cast<double>(n) - swing[n] / (swing[n] - swing[n - 1]));
  REQUIRE(passages.size() > 2);
  const double period = (passages.back() - passages.front()) / static_cast<double>(passages.size() - 1);
  CHECK(48e3 / period == Approx(std::sqrt(slope(0.0) / kMass) / (2 * std::numbers::pi)).epsilon(1e-4));
}

TEST_CASE("attraction: where its force falls it is a negative stiffness", "[physics]") {
  // A stick that a spring holds at d swings with k + F'(d), and falls off with its root if that is below 0.
  const double d = GENERATE(1e-3, 6e-3), stiffness = 50.0, rate = 48e3;
  const auto solver = GENERATE(Solver::Passive, Solver::Implicit, Solver::Explicit, Solver::Exact);
  const auto spec = parse_graph(graph(kMagnet + stick(d) + held(stiffness, "frame = { type = \"ground\" }"),
                                      "out = { from = \"n.energy / 1 J\" }\n"),
                                "test.toml");
  REQUIRE(spec);
  const auto type = network_type((*spec)->networks.front()).value();
  NodeSetup setup{.sample_rate = Hertz{rate}, .type = type.get(), .inputs = {}, .settings = {}};
  for (const auto& port : type->inputs) {
    const double value = port.name == "stick.mass"         ? kMass
                         : port.name == "stick.at"         ? d
                         : port.name == "spring.stiffness" ? stiffness
                         : port.name == "magnet.strength"  ? kStrength
                         : port.name == "magnet.reach"     ? kReach
                                                           : 0.0;
    setup.inputs.push_back({.range = {}, .constant = value, .connected = true});
  }
  const auto node = type->make(setup).value();
  const auto elements = tangent(dynamic_cast<const NetworkView&>(*node).recipe.elements, {});
  const auto network = Network::make(elements, 0, Hertz{rate}, solver, 1).value();
  const double left = (stiffness + slope(d)) / kMass;
  const auto found = modes(linear_step(network, elements, 0).a);
  REQUIRE(!found.empty());
  if (left < 0.0)
    CHECK(std::log(std::abs(found.front().pole)) * rate == Approx(std::sqrt(-left)).epsilon(1e-4));
  else
    CHECK(std::abs(std::arg(found.front().pole)) * rate == Approx(std::sqrt(left)).epsilon(1e-4));
}
