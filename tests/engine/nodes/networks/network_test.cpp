#include "engine/nodes/networks/network.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/named.h"
#include "engine/nodes/networks/network_elements.h"
#include "tests/support/allocation_count.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"
#include "tests/support/parse_graph.h"

using namespace tactus;
using namespace tactus::test;

namespace {

const std::string kDrum = R"(
format = 1
name = "drum"
[inputs]
drive = {}
[networks.drum]
solver = "passive"
oversample = 1
stick = { type = "mass", mass = "12.5 g", at = "20 mm", velocity = "0 m/s" }
cone = { type = "mass", mass = "35 g" }
frame = { type = "ground" }
suspension = { type = "spring", between = ["cone", "frame"], stiffness = "1000 N/m", damping = "1.2 kg/s" }
lens = { type = "contact", between = ["cone", "stick"], stiffness = "5e6 N/m^1.5", exponent = 1.5, loss = "0.15 s/m" }
coil = { type = "coil", on = "cone", voltage = "10 V * drive", force_factor = "6 T m", resistance = "6.5 ohm", inductance = "0.8 mH" }
weight = { type = "force", on = "stick", force = "-0.3 N" }
hand = { type = "hand", on = "stick", stiffness = "10 N/m", damping = "0.02 N s/m", position = "lift", bandwidth = "8 Hz" }
[nodes]
lift = "5 mm"
[outputs]
)";

std::string of_network(const std::string& elements) {
  return "format = 1\nname = \"n\"\n[networks.n]\n" + elements +
         "\n[outputs]\nout = { from = \"n.energy\" }\n";
}

NetworkSpec drum_spec() {
  const auto spec = parse_graph(kDrum + "out = { from = \"drum.stick\" }", "test.toml");
  REQUIRE(spec);
  return (*spec)->networks.front();
}

}  // namespace

TEST_CASE("network node: the drum of a graph file falls, bounces and comes to rest", "[physics]") {
  const auto engine =
      engine_of(kDrum +
                "stick = { from = \"drum.stick / 1 m\" }\npush = { from = \"drum.lens / 1 N\" }\n"
                "current = { from = \"drum.coil.current / 1 A\" }\n"
                "cone = { from = \"drum.cone.position / 1 m\" }");
  const auto out = run(*engine, {Samples(96000, 0.0)}, 96000, {64});
  CHECK(out[0][0] == 0.02);
  // Falls with -0.3 N and the hand's 10 N/m x 15 mm on 12.5 g: first touch well before 50 ms.
  const auto touch = std::find_if(out[1].begin(), out[1].end(), [](double f) { return f > 0.0; });
  CHECK(touch - out[1].begin() < 2400);
  CHECK(*std::max_element(out[1].begin(), out[1].end()) > 5.0);
  // At rest all forces balance: the hand holds 10 N/m (5 mm - x), the weight 0.3 N, the lens the rest.
  CHECK(out[1].back() == Approx(0.3 - 10.0 * (0.005 - out[0].back())).epsilon(1e-3));
  CHECK(out[3].back() == Approx(-out[1].back() / 1000.0).epsilon(1e-3));
  CHECK(out[2].back() == Approx(0.0).margin(1e-6));
}

TEST_CASE("network node: the voltage moves the cone by Bl V / (R K)", "[physics]") {
  const auto engine =
      engine_of(kDrum + "cone = { from = \"drum.cone / 1 m\" }\nlens = { from = \"drum.lens / 1 N\" }");
  const auto out = run(*engine, {Samples(48000, -0.5)}, 48000, {100});
  // The stick lies on the cone by then.
  CHECK(out[0].back() == Approx(-6.0 * 5.0 / (6.5 * 1000.0) - out[1].back() / 1000.0).epsilon(1e-5));
}

TEST_CASE("network node: a loop through a network needs no delay", "[physics]") {
  // The stick is held by a spring made of nodes: force = -100 N/m x, so 10 mm swing at sqrt(100 / 0.01) / 2
  // pi.
  const auto engine = engine_of(R"(
format = 1
name = "loop"
[networks.n]
ball = { type = "mass", mass = "10 g", at = "10 mm" }
pull = { type = "force", on = "ball", force = "spring" }
[nodes]
spring = "-100 N/m * n.ball"
[outputs]
x = { from = "n.ball / 1 m" }
)");
  const auto out = run(*engine, {}, 4800, {64});
  // 100 ms of 100 rad/s; the hold's half frame pumps as damping -K T / 2 m = -0.1 / s: 1 % in 100 ms.
  for (int n = 0; n < 4800; ++n)
    REQUIRE(out[0][std::size_t(n)] == Approx(0.01 * std::cos(100.0 * n / 48e3)).margin(1.2e-4));
}

TEST_CASE("network node: neither cutting nor the way over emit and absorb changes a bit", "[physics]") {
  const auto type = network_type(drum_spec()).value();
  NodeRunner runner(*type, {{"stick.mass", 0.0125},
                            {"stick.at", 0.02},
                            {"cone.mass", 0.035},
                            {"suspension.stiffness", 1000.0},
                            {"suspension.damping", 1.2},
                            {"lens.stiffness", 5e6},
                            {"lens.loss", 0.15},
                            {"coil.force_factor", 6.0},
                            {"coil.resistance", 6.5},
                            {"coil.voltage", noise(5000, 1, -10, 10)},
                            {"weight.force", noise(5000, 2, -2, 0)},
                            {"hand.stiffness", 10.0}});
  CHECK(runner.cutting_matters(5000) == "");
  CHECK(first_difference(runner.run(even_cutting(5000, 64)), runner.run_halves(even_cutting(5000, 1))) == "");
}

TEST_CASE("network node: nothing is allocated while it runs", "[physics]") {
  const auto type = network_type(drum_spec()).value();
  NodeSetup setup{.sample_rate = 48_kHz, .type = type.get(), .inputs = {}, .settings = {}};
  for (const auto& port : type->inputs)
    setup.inputs.push_back({.range = {}, .constant = port.fallback.value_or(1.0), .connected = true});
  const auto node = type->make(setup).value();
  std::vector<Signal> in;
  for (const auto& input : setup.inputs) in.push_back({&*input.constant, 0});
  std::vector<double> samples(64);
  std::vector<double*> out(type->outputs.size(), samples.data());
  const auto before = allocation_count();
  for (int i = 0; i < 200; ++i) node->process({in.data(), out.data(), 64, 64 * i});
  node->reset();
  CHECK(allocation_count() == before);
}

TEST_CASE("network node: signals are late, answers come one frame later, numbers are fixed", "[physics]") {
  const auto type = network_type(drum_spec()).value();
  for (const auto& port : type->inputs) {
    const bool signal = port.name == "coil.voltage" || port.name == "weight.force" ||
                        port.name == "hand.position" || port.name == "hand.force";
    CHECK(port.late == signal);
    CHECK(port.fixed == !signal);
  }
  CHECK(type->inputs[std::size_t(type->input_index("lens.stiffness"))].unit == "N/m^1.5");
  CHECK(type->input_index("lens.restitution") == -1);
  for (const auto* output : {"stick", "stick.position", "stick.velocity", "suspension",
                             "suspension.extension", "lens", "lens.force", "lens.indentation", "coil",
                             "coil.current", "coil.force", "weight", "hand", "hand.position", "energy"})
    CHECK(find_named(type->outputs, output) != nullptr);
  CHECK(find_named(type->outputs, "frame") == nullptr);
}

TEST_CASE("network node: every error in its structure is reported in one go", "[physics]") {
  CHECK(errors_of(of_network(R"(solver = "pasive"
oversample = 0
energy = { type = "mass", mass = "1 g" }
a = { type = "mas", mass = "1 g" }
b = { type = "mass", mas = "1 g" }
s = { type = "spring", between = ["b"], stiffness = "1 N/m" }
t = { type = "spring", between = ["b", "b"], stiffness = "1 N/m" }
u = { type = "contact", between = ["b", "x"], stiffness = 1, loss = "1 s/m", restitution = 0.5 }
v = { type = "force", force = "1 N" }
w = { type = "force", on = "s", force = "1 N" }
g = { type = "ground" }
h = { type = "hand", on = "g" }
c = { type = "coil", on = 3 })")) ==
        R"(test.toml:4:10 UnknownName 'solver' 'pasive' 'passive'
test.toml:5:14 OutOfRange 'oversample' 0 1 64
test.toml:6:1 Duplicate 'energy' 'n.energy'
test.toml:7:14 UnknownName 'mas' 'mass'
test.toml:8:22 UnknownName 'mas' 'mass'
test.toml:9:34 WrongType 's' 1 between "cone" "stick"
test.toml:10:34 Duplicate 't'
test.toml:11:41 UnknownName 'n' 'x' 'energy' 'b' 'g'
test.toml:11:92 Duplicate 'u' 'loss' 'restitution'
test.toml:12:1 Missing 'v' 'on'
test.toml:13:28 WrongType 's'
test.toml:15:27 WrongType 'g'
test.toml:16:27 WrongType 'c')");
}

TEST_CASE("network node: wrong units and missing numbers are found by the compiler", "[physics]") {
  const auto wrong = of_network(R"(a = { type = "mass" }
b = { type = "ground", at = "1 N" }
c = { type = "contact", between = ["a", "b"], stiffness = "1 N/m^1.5", exponent = 2 })");
  CHECK(errors_of(wrong) == R"(test.toml:3:11 Missing 'n' 'a.mass' mass
test.toml:5:30 UnitMismatch 'b.at' 'n'
test.toml:6:60 UnitMismatch 'c.stiffness' 'n' 2 1.5 2
test.toml:8:1 UnitMismatch 'out' unit "J")");
  const auto compiled = compile(parse_graph_leniently(wrong, "test.toml"), standard_nodes(), {});
  REQUIRE_FALSE(compiled);
  CHECK(to_string(compiled.error()).find("N/m^2") != std::string::npos);
}

TEST_CASE("network node: the reference names every element, its unit and its doc", "[physics]") {
  for (const auto& type : network_elements()) {
    CHECK_FALSE(type.doc.empty());
    CHECK_FALSE(type.equation.empty());
    CHECK(type.example.find("type = \"" + type.name + "\"") != std::string::npos);
    for (const auto& field : type.fields) {
      CHECK_FALSE(field.doc.empty());
      CHECK((field.unit == "N/m^exponent" || parse_unit(field.unit)));
    }
    for (const auto& quantity : type.quantities) CHECK(parse_unit(quantity.unit));
  }
}
