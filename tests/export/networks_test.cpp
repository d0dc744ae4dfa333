#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <regex>

#include "engine/nodes/networks/network_elements.h"
#include "engine/nodes/networks/solver_names.h"
#include "tests/conformance/node_cases.h"
#include "tests/export/compiled_programs.h"
#include "tests/support/random_networks.h"

// Networks: every element with every solver, exported, compiled as C99 and run, with the bits of the engine.

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr int kNetworkFrames = 3000;
constexpr Solver kExported[] = {Solver::Explicit, Solver::Passive, Solver::Implicit, Solver::Exact,
                                Solver::Auto};

/// Elements around one of a type, so that it acts. The signals are f, g [N], p, q [mm], v [V] and w [N].
struct ElementCase {
  const char* name;
  const char* elements;
  bool stiff = false;  ///< too stiff for the explicit solver
};

constexpr ElementCase kElementCases[] = {
    {"mass", R"toml(
m = { type = "mass", mass = "10 g", at = "1 mm", velocity = "0.2 m/s" }
floor = { type = "ground", at = "-1 mm" }
hold = { type = "spring", between = ["floor", "m"], stiffness = "4 kN/m", damping = "0.3 N s/m" }
push = { type = "force", on = "m", force = "f * 1 N" }
)toml"},
    {"oscillator", R"toml(
o = { type = "oscillator", mass = "20 g", frequency = "440 Hz", damping_ratio = 0.001, at = "1 mm" }
other = { type = "oscillator", mass = "20 g", stiffness = "1 N/m", damping = "0.1 N s/m", rest = "1 mm" }
push = { type = "force", on = "o", force = "f * 1 N" }
)toml"},
    {"motion", R"toml(
table = { type = "motion", position = "p * 1 mm" }
m = { type = "mass", mass = "10 g" }
hold = { type = "spring", between = ["table", "m"], stiffness = "40 kN/m", damping = "0.3 N s/m", rest = "2 mm" }
)toml"},
    {"only a motion", R"toml(
table = { type = "motion", position = "p * 1 mm" }
)toml"},
    {"chain", R"toml(
string = { type = "chain", masses = 37, mass = "0.1 g", stiffness = "57 kN/m", damping = "1e-3 N s/m" }
push = { type = "force", on = "string.5", force = "f * 1 N" }
ear = { type = "probe", on = "string.20" }
)toml"},
    {"short chain", R"toml(
string = { type = "chain", masses = 5, mass = "1 g", stiffness = "57 kN/m", damping = "1e-3 N s/m", ground_damping = "0.01 N s/m" }
push = { type = "force", on = "string.2", force = "f * 1 N" }
ear = { type = "probe", on = "string.4" }
)toml"},
    {"bar", R"toml(
bar = { type = "chain", masses = 24, mass = "1 g", stiffness = "1 N/m", bending_stiffness = "20 kN/m", ends = "clamped" }
hand = { type = "hand", on = "bar.3", stiffness = "100 N/m", position = "p * 1 mm" }
ear = { type = "probe", on = "bar.20" }
)toml"},
    {"ring", R"toml(
hoop = { type = "ring", masses = 21, mass = "1 g", stiffness = "10 kN/m", ground_stiffness = "10 N/m" }
push = { type = "force", on = "hoop.5", force = "f * 1 N" }
ear = { type = "probe", on = "hoop.20" }
)toml"},
    {"grid", R"toml(
skin = { type = "grid", rows = 5, columns = 20, mass = "1 g", stiffness = "20 kN/m", damping = "0.01 N s/m" }
push = { type = "force", on = "skin.2.3", force = "f * 1 N" }
ear = { type = "probe", on = "skin.4.4" }
)toml"},
    {"plate", R"toml(
plate = { type = "grid", rows = 4, columns = 5, mass = "1 g", stiffness = "1 N/m", bending_stiffness = "2 kN/m", ends = "clamped" }
push = { type = "force", on = "plate.2.3", force = "f * 1 N" }
ear = { type = "probe", on = "plate.4.4" }
)toml"},
    {"spring", R"toml(
floor = { type = "ground" }
m = { type = "mass", mass = "10 g" }
soft = { type = "spring", between = ["floor", "m"], stiffness = "100 N/m", cubic = "3e8 N/m^3", rest = "1 mm" }
push = { type = "force", on = "m", force = "f * 5 N" }
)toml"},
    {"damper", R"toml(
floor = { type = "ground" }
m = { type = "mass", mass = "10 g" }
n = { type = "mass", mass = "20 g", velocity = "1 m/s" }
stiff = { type = "damper", between = ["m", "n"], damping = "200 N s/m" }
loose = { type = "damper", between = ["floor", "m"], damping = "0.1 N s/m" }
push = { type = "force", on = "m", force = "f * 5 N" }
)toml"},
    {"coil", R"toml(
m = { type = "oscillator", mass = "10 g", stiffness = "1 kN/m", damping = "0.2 N s/m" }
n = { type = "mass", mass = "100 g" }
coil = { type = "coil", on = "m", voltage = "v * 1 V", force_factor = "6 T m", resistance = "6.5 ohm", inductance = "0.5 mH" }
plain = { type = "coil", on = "m", against = "n", voltage = "f * 1 V", force_factor = "3 T m", resistance = "4 ohm" }
)toml"},
    {"contact", R"toml(
table = { type = "ground" }
a = { type = "mass", mass = "10 g", at = "1 mm" }
b = { type = "mass", mass = "20 g", at = "2 mm", velocity = "-0.5 m/s" }
c = { type = "mass", mass = "5 g", at = "3 mm" }
weight = { type = "force", on = "a", force = "-2 N + f * 3 N" }
other = { type = "force", on = "b", force = "-3 N" }
third = { type = "force", on = "c", force = "-1 N" }
one = { type = "contact", between = ["table", "a"], stiffness = "1e6 N/m^1.5", loss = "0.5 s/m" }
two = { type = "contact", between = ["a", "b"], stiffness = "1e5 N/m", exponent = 1, restitution = 0.6 }
three = { type = "contact", between = ["b", "c"], stiffness = "1e8 N/m^2", exponent = 2 }
)toml"},
    {"hard contact", R"toml(
table = { type = "ground" }
a = { type = "mass", mass = "10 g", at = "1 mm" }
weight = { type = "force", on = "a", force = "-2 N + f * 3 N" }
one = { type = "contact", between = ["table", "a"], stiffness = "1e10 N/m^1.5", restitution = 0.4, offset = "0.1 mm" }
)toml",
     true},
    {"gap", R"toml(
table = { type = "motion", position = "p * 1 mm" }
a = { type = "mass", mass = "10 g" }
other = { type = "mass", mass = "10 g", at = "1 mm" }
push = { type = "force", on = "a", force = "f * 3 N" }
gap = { type = "contact", between = ["a", "table"], stiffness = "3e7 N/m^1.7", exponent = 1.7, sides = 2, clearance = "0.3 mm" }
hard = { type = "contact", between = ["a", "other"], stiffness = "3e10 N/m^3", exponent = 3, loss = "0.1 s/m" }
)toml"},
    {"friction", R"toml(
bow = { type = "motion", position = "q * 5 mm" }
floor = { type = "ground" }
string = { type = "oscillator", mass = "2 g", frequency = "200 Hz", damping_ratio = 0.01 }
block = { type = "mass", mass = "50 g", velocity = "0.3 m/s" }
hair = { type = "friction", between = ["bow", "string"], normal = "1 N + f * 0.5 N", law = "rosin" }
brake = { type = "friction", between = ["block", "floor"], normal = "0.5 N", kinetic = 0.3, holding = 0.5, viscous = "0.1 N s/m" }
push = { type = "force", on = "block", force = "g * 2 N" }
)toml"},
    {"pressed friction", R"toml(
floor = { type = "ground" }
a = { type = "mass", mass = "10 g" }
b = { type = "mass", mass = "30 g", velocity = "0.2 m/s" }
hold = { type = "spring", between = ["floor", "a"], stiffness = "1 kN/m", damping = "0.2 N s/m" }
join = { type = "spring", between = ["a", "b"], stiffness = "500 N/m", rest = "1 mm" }
press = { type = "contact", between = ["floor", "b"], stiffness = "1e5 N/m", exponent = 1 }
one = { type = "friction", between = ["a", "b"], normal = "hold.force" }
two = { type = "friction", between = ["b", "floor"], normal = "press.force", holding = 0.6 }
push = { type = "force", on = "b", force = "g * 2 N" }
)toml"},
    {"pluck", R"toml(
pick = { type = "motion", position = "q * 4 mm" }
string = { type = "oscillator", mass = "2 g", frequency = "200 Hz", damping_ratio = 0.01 }
plectrum = { type = "pluck", between = ["pick", "string"], stiffness = "5 kN/m", limit = "2 N", damping = "0.1 N s/m" }
)toml"},
    {"stretched pluck", R"toml(
a = { type = "oscillator", mass = "2 g", frequency = "200 Hz", at = "2 mm" }
b = { type = "oscillator", mass = "3 g", frequency = "300 Hz" }
first = { type = "pluck", between = ["a", "b"], stiffness = "5 kN/m", limit = "2 N" }
second = { type = "pluck", between = ["a", "b"], stiffness = "1 kN/m", limit = "3 N", damping = "500 N s/m" }
push = { type = "force", on = "b", force = "f * 1 N" }
)toml",
     true},
    {"attraction", R"toml(
base = { type = "ground", at = "1 mm" }
a = { type = "oscillator", mass = "12 g", stiffness = "200 N/m", damping = "0.05 N s/m" }
b = { type = "mass", mass = "12 g", at = "3 mm" }
magnet = { type = "attraction", between = ["base", "a"], strength = "2 N", reach = "1 mm" }
pair = { type = "attraction", between = ["a", "b"], strength = "1 N", reach = "2 mm" }
plectrum = { type = "pluck", between = ["b", "base"], stiffness = "1 kN/m", limit = "4 N" }
push = { type = "force", on = "a", force = "f * 1 N" }
)toml"},
    {"hand", R"toml(
m = { type = "mass", mass = "10 g", at = "1 mm" }
hand = { type = "hand", on = "m", stiffness = "100 N/m", damping = "1 N s/m", position = "p * 1 mm", force = "g * 1 N" }
table = { type = "ground" }
hit = { type = "contact", between = ["table", "m"], stiffness = "1e5 N/m^1.5" }
)toml"},
    {"port", R"toml(
body = { type = "oscillator", mass = "10 g", frequency = "300 Hz", damping_ratio = 0.01 }
other = { type = "mass", mass = "1 g" }
bridge = { type = "port", on = "body", impedance = "0.5 N s/m", wave = "w * 1 N" }
stiff = { type = "port", on = "other", impedance = "500 N s/m", wave = "f * 1 N" }
)toml",
     true},
    {"particle", R"toml(
hook = { type = "anchor", axes = 2, y = "0.5 m" }
bob = { type = "particle", axes = 2, mass = "0.1 kg", x = "0.3 m", velocity_x = "1 m/s" }
cord = { type = "line_spring", between = ["hook", "bob"], stiffness = "2 kN/m", damping = "1 N s/m" }
weight = { type = "force", on = "bob.y", force = "-1 N + f * 1 N" }
wall = { type = "ground", at = "0.2 m" }
hit = { type = "contact", between = ["wall", "bob.x"], stiffness = "1e5 N/m^1.5" }
)toml"},
    {"trajectory", R"toml(
finger = { type = "trajectory", x = "p * 1 mm", y = "q * 1 mm" }
bob = { type = "particle", mass = "0.1 kg", x = "0.3 m" }
end = { type = "anchor", x = "0.6 m", y = "0.1 m" }
cord = { type = "line_spring", between = ["finger", "bob"], stiffness = "2 kN/m", rest = "0.28 m" }
other = { type = "line_spring", between = ["bob", "end"], stiffness = "1 kN/m", damping = "0.5 N s/m" }
)toml"},
    {"straight lines", R"toml(
bob = { type = "particle", mass = "0.1 kg", x = "0.3 m", y = "0.1 m" }
end = { type = "anchor", x = "0.6 m", y = "0.3 m" }
other = { type = "line_spring", between = ["bob", "end"], stiffness = "10 kN/m", damping = "0.5 N s/m", tension = "5 N", geometry = "linear" }
push = { type = "force", on = "bob.z", force = "f * 1 N" }
)toml"},
    {"thread", R"toml(
string = { type = "thread", masses = 6, mass = "0.5 g", stiffness = "5 kN/m", spacing = "20 mm", tension = "20 N", damping = "0.01 N s/m", ground_damping = "0.001 N s/m" }
push = { type = "force", on = "string.2.y", force = "f * 1 N" }
ear = { type = "probe", on = "string.4.y" }
rub = { type = "friction", between = ["string.3.z", "floor"], normal = "0.2 N" }
floor = { type = "ground" }
)toml"},
    {"sheet", R"toml(
skin = { type = "sheet", rows = 2, columns = 3, mass = "1 g", stiffness = "20 kN/m", spacing = "30 mm", tension = "60 N", shear_stiffness = "1 kN/m" }
push = { type = "force", on = "skin.2.1.z", force = "f * 1 N" }
ear = { type = "probe", on = "skin.1.2.z" }
)toml"},
    {"straight sheet", R"toml(
skin = { type = "sheet", rows = 3, columns = 3, mass = "1 g", stiffness = "20 kN/m", spacing = "30 mm", tension = "60 N", geometry = "linear" }
push = { type = "force", on = "skin.2.1.z", force = "f * 1 N" }
ear = { type = "probe", on = "skin.1.2.z" }
)toml"},
};

const std::string kNetworkInputs = "[inputs]\nf = {}\ng = {}\np = {}\nq = {}\nv = {}\nw = {}\n";

/// Forces and voltages jump from frame to frame, places do not.
Channels network_inputs(int frames) {
  Channels in{noise(frames, 1), noise(frames, 2), noise(frames, 3),
              noise(frames, 4), noise(frames, 5), noise(frames, 6)};
  for (const auto& [channel, hertz] : {std::pair{1, 20.0}, {2, 47.0}, {3, 31.0}})
    for (int n = 0; n < frames; ++n)
      in[index(channel)][index(n)] = std::sin(0.4 + 2.0 * std::numbers::pi * hertz * n / 48000.0);
  return in;
}

/// [networks.NAME] and an output for each quantity of its elements, and for its energy.
struct NetworkGraph {
  std::string networks, outputs;

  void add(const std::string& name, const std::string& solver, const std::string& elements,
           int oversample = 1) {
    networks += "[networks." + name + "]\nsolver = \"" + solver +
                "\"\noversample = " + std::to_string(oversample) + "\n" + elements;
    const std::regex line{"(?:^|\n)(\\w+) = \\{ type = \"(\\w+)\"([^\n]*)"};
    for (std::sregex_iterator it{elements.begin(), elements.end(), line}, end; it != end; ++it) {
      const bool flat = it->str(3).find("axes = 2") != std::string::npos;
      const auto* type = find_element(it->str(2));
      const bool many = type->dimensions > 0;
      for (const auto& quantity : type->quantities)
        if (!many && (quantity.axis == 0 || !flat))
          give(name + "." + it->str(1) + "." + quantity.name, quantity.unit);
    }
    give(name + ".energy", "J");
  }
  void give(const std::string& signal, const std::string& unit) {
    outputs += "y" + std::to_string(count++) + " = { from = \"" + plain_signal(signal, unit) + "\" }\n";
  }
  std::string text(const std::string& name) const {
    return "format = 1\nname = \"" + name + "\"\n" + kNetworkInputs + networks + "[outputs]\n" + outputs;
  }

  int count = 0;
};

std::string file_name(std::string name) {
  std::ranges::replace(name, ' ', '_');
  return name;
}

void check_bits(const std::map<std::string, std::string>& texts, int frames) {
  CompiledPrograms programs;
  for (const auto& [name, text] : texts) {
    INFO(text);
    REQUIRE(programs.add(text, exact_options()) == "");
  }
  programs.compile();
  const auto in = network_inputs(frames);
  for (const auto& [name, text] : texts) {
    INFO(text);
    auto engine = engine_for(parse_graph_leniently(text, "test.toml"), exact_options());
    const auto expected = run(engine, in, frames, {64});
    CHECK(first_difference(programs.run(name, in, frames), expected) == "");
    CHECK(std::ranges::any_of(expected, [](const auto& channel) {
      return std::ranges::any_of(channel, [](double x) { return x != 0; });
    }));
  }
}

}  // namespace

TEST_CASE("export: every element of networks gives the bits of the engine with every solver",
          "[export][physics]") {
  std::map<std::string, std::string> texts;
  std::string all;
  for (const auto& one : kElementCases) {
    NetworkGraph graph;
    for (const auto solver : kExported)
      if (solver != Solver::Explicit || !one.stiff) graph.add(name_of(solver), name_of(solver), one.elements);
    texts[file_name(one.name)] = graph.text(file_name(one.name));
    all += one.elements;
  }
  for (const auto& type : network_elements()) {
    INFO(type.name);
    CHECK(all.find("type = \"" + type.name + "\"") != std::string::npos);
  }
  check_bits(texts, kNetworkFrames);
}

TEST_CASE("export: networks of several steps a frame give the bits of the engine",
          "[export][physics][slow]") {
  std::map<std::string, std::string> texts;
  for (const auto& one : kElementCases) {
    NetworkGraph graph;
    for (const auto solver : {Solver::Explicit, Solver::Passive, Solver::Implicit, Solver::Exact})
      if (solver != Solver::Explicit || !one.stiff)
        graph.add(name_of(solver), name_of(solver), one.elements, 3);
    texts[file_name(one.name)] = graph.text(file_name(one.name));
  }
  check_bits(texts, 500);
}

namespace {

/// A random network as its file would have it. Friction by its law, plucks for bonds.
std::string elements_of(const RandomNetwork& network) {
  const auto& all = network.elements;
  std::string text;
  const auto add = [&](const char* letter, std::size_t number, const char* type, const std::string& keys) {
    text += fmt::format("{}{} = {{ type = \"{}\", {} }}\n", letter, number, type, keys);
  };
  const auto between = [](const auto& link) {
    return fmt::format("between = [\"p{}\", \"p{}\"]", link.lower, link.upper);
  };
  for (std::size_t i = 0; i < all.points.size(); ++i)
    if (const auto& p = all.points[i]; p.kind == Point::Kind::Mass)
      add("p", i, "mass", fmt::format("mass = {}, at = {}, velocity = {}", p.mass, p.position, p.velocity));
    else
      add("p", i, "ground", fmt::format("at = {}", p.position));
  for (std::size_t i = 0; i < all.springs.size(); ++i) {
    const auto& s = all.springs[i];
    add("s", i, "spring",
        fmt::format("{}, stiffness = {}, damping = {}, rest = {}", between(s), s.stiffness, s.damping,
                    s.rest));
  }
  for (std::size_t i = 0; i < all.contacts.size(); ++i) {
    const auto& c = all.contacts[i];
    add("c", i, "contact",
        fmt::format("{}, stiffness = {}, exponent = {}, offset = {}{}", between(c), c.stiffness, c.exponent,
                    c.offset,
                    c.restitution  ? fmt::format(", restitution = {}", *c.restitution)
                    : c.loss > 0.0 ? fmt::format(", loss = {}", c.loss)
                                   : ""));
  }
  for (std::size_t i = 0; i < all.coils.size(); ++i) {
    const auto& c = all.coils[i];
    add("k", i, "coil",
        fmt::format(
            "on = \"p{}\", against = \"p{}\", voltage = \"v * 1 V\", force_factor = {}, resistance = {}, "
            "inductance = {}",
            c.on, c.against, c.force_factor, c.resistance, c.inductance));
  }
  for (std::size_t i = 0; i < all.ports.size(); ++i)
    add("o", i, "port",
        fmt::format("on = \"p{}\", impedance = {}, wave = \"w * 1 N\"", all.ports[i].on,
                    all.ports[i].impedance));
  for (std::size_t i = 0; i < all.frictions.size(); ++i) {
    const auto& f = all.frictions[i];
    const auto& drop = f.law.drops[0];
    const auto law = f.law.drops[1].size > 0.0
                         ? std::string{"law = \"rosin\""}
                         : fmt::format("kinetic = {}, holding = {}, speed = {}", f.law.kinetic,
                                       f.law.kinetic + drop.size, drop.speed);
    add("f", i, "friction",
        fmt::format("{}, normal = \"s{}.force\", viscous = {}, {}", between(f), f.normal_spring, f.viscous,
                    law));
  }
  for (std::size_t i = 0; i < all.bonds.size(); ++i) {
    const auto& b = all.bonds[i];
    add("b", i, "pluck",
        fmt::format("{}, stiffness = {}, damping = {}, limit = {}", between(b), b.law->stiffness(0.0),
                    b.damping, std::min(b.limit, 1e12)));
  }
  for (std::size_t i = 0; i < all.forces.size(); ++i)
    add("u", i, "force", fmt::format("on = \"p{}\", force = \"f * 1 N\"", all.forces[i].on));
  return text;
}

/// Whether a solver can be made and is stable: a fault of one network resets a whole program.
bool stays_small(const std::string& text, int frames) {
  auto plan = compile(parse_graph_leniently(text, "test.toml"), standard_nodes(), {});
  if (!plan) return false;
  Player engine{std::move(*plan)};
  const auto out = run(engine, network_inputs(frames), frames, {64});
  return std::ranges::all_of(out,
                             [](const auto& channel) {
                               return std::ranges::all_of(channel,
                                                          [](double x) { return std::abs(x) < 1e30; });
                             }) &&
         std::ranges::any_of(out.back(), [](double energy) { return energy != 0; });
}

}  // namespace

TEST_CASE("export: random networks give the bits of the engine", "[export][physics]") {
  std::map<std::string, std::string> texts;
  for (std::uint64_t seed = 1; texts.size() < 30; ++seed) {
    const auto elements = elements_of(RandomNetworks{seed}.make());
    NetworkGraph graph;
    for (const auto solver : {Solver::Explicit, Solver::Passive, Solver::Implicit, Solver::Exact}) {
      NetworkGraph alone;
      alone.add("n", name_of(solver), elements);
      if (stays_small(alone.text("one"), 400)) graph.add(name_of(solver), name_of(solver), elements);
    }
    const auto name = "random_" + std::to_string(seed);
    texts[name] = graph.text(name);
  }
  check_bits(texts, 400);
}

namespace {

/// The largest error of floats, as a share of the largest value of an output: docs/export.md. The exact
/// solver works out the next place itself, the others how far it goes.
double float_bound(const std::string& elements, Solver solver) {
  for (const char* sudden : {"contact", "friction", "pluck", "hand"})
    if (elements.find(std::string{"type = \""} + sudden) != std::string::npos)
      return std::numeric_limits<double>::infinity();  // what begins in another frame
  return solver == Solver::Exact ? 0.1 : 3e-3;
}

double share_of_error(const Samples& expected, const Samples& found) {
  double size = 0, error = 0;
  for (std::size_t n = 0; n < expected.size(); ++n) {
    size = std::max(size, std::abs(expected[n]));
    error = std::max(error, std::abs(expected[n] - found[n]));
  }
  return error == 0 ? 0 : error / size;
}

}  // namespace

TEST_CASE("export: networks in floats are within their stated errors of the engine",
          "[export][physics][slow]") {
  auto single = exact_options();
  single.number = find_number_type("float");
  struct FloatCase {
    std::string text;
    double bound;
  };
  std::map<std::string, FloatCase> cases;
  CompiledPrograms programs;
  for (const auto& one : kElementCases)
    for (const auto solver : {Solver::Explicit, Solver::Passive, Solver::Implicit, Solver::Exact}) {
      if (solver == Solver::Explicit && one.stiff) continue;
      NetworkGraph graph;
      graph.add("n", name_of(solver), one.elements);
      const auto name = file_name(one.name) + "_" + name_of(solver);
      cases[name] = {graph.text(name), float_bound(one.elements, solver)};
      REQUIRE(programs.add(cases[name].text, single) == "");
    }
  programs.compile("-O1 -Wdouble-promotion");
  const auto in = network_inputs(kNetworkFrames);
  for (const auto& [name, one] : cases) {
    INFO(one.text);
    auto engine = engine_for(parse_graph_leniently(one.text, "test.toml"), exact_options());
    const auto expected = run(engine, in, kNetworkFrames, {64}),
               found = programs.run(name, in, kNetworkFrames);
    for (std::size_t c = 0; c < expected.size(); ++c) {
      INFO(name << " output " << c);
      CHECK(share_of_error(expected[c], found[c]) <= one.bound);
    }
  }
}

TEST_CASE("export: a network is refused by name where its numbers are integers", "[export][physics]") {
  NetworkGraph graph;
  graph.add("n", "passive", kElementCases[0].elements);
  auto options = exact_options();
  options.number = find_number_type("q31");
  const auto program =
      write_fixed_program(parse_graph_leniently(graph.text("fixed"), "test.toml"), standard_nodes(), options);
  REQUIRE_FALSE(program);
  const auto found = std::ranges::find_if(program.error(), [](const Error& error) {
    return error.what.find("network 'n'") != std::string::npos;
  });
  REQUIRE(found != program.error().end());
  CHECK_THAT(found->remedy, Catch::Contains("--number"));
}

TEST_CASE("export: a program holds nothing of a network that it does not need", "[export][physics]") {
  const auto source = [](const char* solver, const std::string& elements, const std::string& output) {
    const auto text = "format = 1\nname = \"lean\"\n" + kNetworkInputs + "[networks.n]\nsolver = \"" +
                      solver + "\"\n" + elements + "[outputs]\ny = { from = \"" + output + "\" }\n";
    const auto program =
        write_program(parse_graph_leniently(text, "test.toml"), standard_nodes(), exact_options());
    REQUIRE(program);
    return exact_options().target->files(*program)[1].text;
  };
  const auto plain = source("explicit", kElementCases[0].elements, "n.m.position / 1 m");
  for (const char* word : {"contact", "friction", "velocity", "_solve", "settle", "low_pass", "pow"}) {
    INFO(word);
    CHECK(plain.find(word) == std::string::npos);
  }
  const std::string hit =
      "m = { type = \"mass\", mass = \"1 g\" }\nfloor = { type = \"ground\" }\nhit = { type = \"contact\", "
      "between "
      "= [\"floor\", \"m\"], stiffness = \"1e5 N/m^1.5\" }\npush = { type = \"force\", on = \"m\", force = "
      "\"f "
      "* 1 N\" }\n";
  const auto elastic = source("passive", hit, "n.m.position / 1 m");
  for (const char* word : {"pow(", "log1p", "cholesky", "_bond", "_friction"}) {
    INFO(word);
    CHECK(elastic.find(word) == std::string::npos);
  }
}
