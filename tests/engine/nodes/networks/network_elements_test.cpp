#include "engine/nodes/networks/network_elements.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <regex>

#include "tests/support/allocation_count.h"
#include "tests/support/error_summary.h"
#include "tests/support/graphs/graph_runner.h"

using namespace tactus;
using namespace tactus::test;

namespace {

using Samples = std::vector<double>;

std::string graph(const std::string& elements, const std::string& out) {
  return "format = 1\nname = \"n\"\n[networks.n]\n" + elements + "\n[outputs]\nout = { from = \"" + out +
         "\" }\n";
}

Samples play(const std::string& elements, const std::string& out, int frames) {
  return run(*engine_of(graph(elements, out)), {}, frames, {64})[0];
}

/// Frames between upward passages through 0, on average.
double period(const Samples& x) {
  std::vector<double> passages;
  for (std::size_t n = 1; n < x.size(); ++n)
    if (x[n - 1] < 0.0 && x[n] >= 0.0) passages.push_back(static_cast<double>(n) - x[n] / (x[n] - x[n - 1]));
  REQUIRE(passages.size() > 2);
  return (passages.back() - passages.front()) / static_cast<double>(passages.size() - 1);
}

std::string element_errors(const std::string& elements) {
  return errors_of(graph(elements, "n.energy / 1 J"));
}

}  // namespace

TEST_CASE("network elements: an oscillator by resonance and damping ratio", "[physics]") {
  // zeta = 0.01 at 100 Hz: w_d = w sqrt(1 - zeta^2), falls to exp(-zeta w t).
  const auto solver = GENERATE("exact", "passive", "implicit", "explicit");
  const auto x =
      play(std::string("solver = \"") + solver +
               "\"\no = { type = \"oscillator\", mass = \"20 g\", frequency = \"100 Hz\", damping_ratio = "
               "0.01, at = \"1 mm\" }",
           "n.o.position / 1 mm", 48000);
  CHECK(48e3 / period(x) == Approx(100 * std::sqrt(1 - 1e-4)).epsilon(1e-4));
  const double highest = *std::max_element(x.begin() + 24000, x.begin() + 24000 + 480);
  CHECK(std::log(highest) == Approx(-0.01 * 2 * std::numbers::pi * 100 * 0.505).epsilon(0.02));
}

TEST_CASE("network elements: a cubic spring swings faster the further it goes", "[physics]") {
  // F = -c x^3:  T = 7.4163 sqrt(m / c) / A (an elliptic integral).
  const auto swing = GENERATE(0.001, 0.003);
  const auto solver = GENERATE("exact", "passive", "implicit", "explicit");
  const auto x = play(
      std::string("solver = \"") + solver +
          "\"\nf = { type = \"ground\" }\nm = { type = \"mass\", mass = "
          "\"10 g\", at = " +
          std::to_string(swing) +
          " }\ns = { type = \"spring\", between = [\"f\", \"m\"], stiffness = 0, cubic = \"1e9 N/m^3\" }",
      "n.m.position / 1 m", 48000);
  CHECK(period(x) / 48e3 == Approx(7.4163 * std::sqrt(0.01 / 1e9) / swing).epsilon(1e-3));
}

TEST_CASE("network elements: a contact with two sides holds from below and above", "[physics]") {
  // Free over 2 x 1 mm at 1 m/s, then a linear contact of half a period at either end.
  const auto x = play(
      "f = { type = \"ground\" }\nm = { type = \"mass\", mass = \"10 g\", velocity = \"1 m/s\" }\n"
      "c = { type = \"contact\", between = [\"m\", \"f\"], stiffness = \"4e5 N/m\", exponent = 1, sides = 2, "
      "clearance = \"1 mm\" }",
      "n.m.position / 1 m", 48000);
  const double touch = std::numbers::pi * std::sqrt(0.01 / 4e5);
  CHECK(period(x) / 48e3 == Approx(2 * (2 * 0.001 + touch)).epsilon(2e-3));
  const auto force = play(
      "f = { type = \"ground\" }\nm = { type = \"mass\", mass = \"10 g\", velocity = \"1 m/s\" }\n"
      "c = { type = \"contact\", between = [\"m\", \"f\"], stiffness = \"4e5 N/m\", exponent = 1, sides = 2, "
      "clearance = \"1 mm\" }",
      "n.c.force / 1 N", 48000);
  const auto [least, most] = std::minmax_element(force.begin(), force.end());
  CHECK(*most == Approx(std::sqrt(0.01 * 4e5)).epsilon(0.01));
  CHECK(*least == Approx(-*most).epsilon(0.01));
}

TEST_CASE("network elements: a chain has the modes of its masses, fixed, free or closed", "[physics]") {
  // Struck in the middle of symmetry by its own mode it stays in it: here the lowest one dominates a slow
  // push. fixed: w = 2 w0 sin(pi / (2 (n + 1))); a ring of 4 with its second mass held: w0 sqrt(2 - sqrt 2).
  const auto solver = GENERATE("exact", "passive", "implicit", "explicit");
  const auto start = std::string("solver = \"") + solver + "\"\n";
  const double w0 = std::sqrt(1000.0 / 0.01);
  const auto fixed =
      play(start +
               "c = { type = \"chain\", masses = 1, mass = \"10 g\", stiffness = \"1000 N/m\" }\n"
               "p = { type = \"probe\", on = \"c.1\" }\n"
               "kick = { type = \"force\", on = \"c.1\", force = \"1 N\" }",
           "n.p / 1 m - 0.0005", 48000);
  CHECK(2 * std::numbers::pi * 48e3 / period(fixed) == Approx(w0 * std::sqrt(2.0)).epsilon(1e-3));
  const auto ring = play(
      start +
          "r = { type = \"ring\", masses = 4, mass = \"10 g\", stiffness = \"1000 N/m\" }\n"
          "p = { type = \"probe\", on = \"r.1\" }\nf = { type = \"force\", on = \"r.1\", force = \"1 N\" }\n"
          "b = { type = \"force\", on = \"r.2\", force = \"-1 N\" }\n"
          "d = { type = \"force\", on = \"r.3\", force = \"1 N\" }\n"
          "e = { type = \"force\", on = \"r.4\", force = \"-1 N\" }",
      "n.p / 1 m - 0.00025", 48000);
  // All neighbours against each other: w = 2 w0.
  CHECK(2 * std::numbers::pi * 48e3 / period(ring) == Approx(2 * w0).epsilon(1e-3));
  const auto free =
      play(start +
               "c = { type = \"chain\", masses = 3, mass = \"10 g\", stiffness = \"1000 N/m\", ends = "
               "\"free\" }\np = { type = \"probe\", on = \"c.3\" }\n"
               "f = { type = \"force\", on = \"c.1\", force = \"1 N\" }\n"
               "g = { type = \"force\", on = \"c.3\", force = \"-1 N\" }",
           "n.p / 1 m + 0.001", 48000);
  // Its ends against each other, the middle at rest: w = w0 about -F / k.
  CHECK(2 * std::numbers::pi * 48e3 / period(free) == Approx(w0).epsilon(1e-3));
}

TEST_CASE("network elements: the lowest mode of a square grid", "[physics]") {
  // A grid of 3 x 3 pushed in its mode's shape: w = w0 sqrt(8) sin(pi / 8).
  std::string forces;
  for (int r = 1; r <= 3; ++r)
    for (int c = 1; c <= 3; ++c) {
      const double shape = std::sin(r * std::numbers::pi / 4) * std::sin(c * std::numbers::pi / 4);
      forces += "f" + std::to_string(r) + std::to_string(c) + " = { type = \"force\", on = \"g." +
                std::to_string(r) + "." + std::to_string(c) + "\", force = " + std::to_string(shape) + " }\n";
    }
  const double w0 = std::sqrt(1000.0 / 0.01), w = w0 * std::sqrt(8.0) * std::sin(std::numbers::pi / 8);
  const auto x = play(
      "solver = \"exact\"\ng = { type = \"grid\", rows = 3, columns = 3, mass = \"10 g\", stiffness = \"1000 "
      "N/m\" }\np = { type = \"probe\", on = \"g.2.2\" }\n" +
          forces,
      "n.p / 1 m - " + std::to_string(1.0 / (0.01 * w * w)), 48000);
  CHECK(2 * std::numbers::pi * 48e3 / period(x) == Approx(w).epsilon(1e-4));
}

TEST_CASE("network elements: a bow takes a string along as far as its press allows", "[physics]") {
  // Pressed with 2 N and mu = 0.5 the string follows the bow while its spring pulls less than 1 N: 1 mm.
  const auto end = GENERATE(0.0009, 0.003);
  const auto engine = engine_of(
      "format = 1\nname = \"n\"\n[inputs]\nstroke = { unit = \"m\" }\n[networks.n]\nf = { type = \"ground\" "
      "}\n"
      "h = { type = \"mass\", mass = \"1 g\", at = \"-0.2 mm\" }\n"
      "press = { type = \"spring\", between = [\"h\", \"f\"], stiffness = \"1e4 N/m\", damping = \"6 N s/m\" "
      "}\n"
      "weight = { type = \"force\", on = \"h\", force = \"-2 N\" }\nbow = { type = \"motion\", position = "
      "\"stroke\" }\n"
      "s = { type = \"oscillator\", mass = \"1 g\", stiffness = \"1000 N/m\", damping = \"2 N s/m\" }\n"
      "hair = { type = \"friction\", between = [\"bow\", \"s\"], normal = \"press.force\", kinetic = 0.5 }\n"
      "[outputs]\nforce = { from = \"n.hair.force / 1 N\" }\nplace = { from = \"n.s / 1 m\" }");
  Samples stroke(48000);
  for (std::size_t n = 0; n < stroke.size(); ++n)
    stroke[n] = end * std::min(1.0, static_cast<double>(n) / 24000);
  const auto out = run(*engine, {stroke}, 48000, {64});
  const double pull = std::min(1.0, 1000 * end);
  CHECK(out[0].back() == Approx(pull).epsilon(1e-3));
  CHECK(out[1].back() == Approx(pull / 1000).epsilon(1e-3));
}

TEST_CASE("network elements: nothing is allocated while any solver runs", "[physics]") {
  const std::string solver = GENERATE("exact", "passive", "implicit", "explicit", "auto");
  const auto engine = engine_of(
      "format = 1\nname = \"n\"\n[inputs]\nx = {}\n[networks.n]\nsolver = \"" + solver +
      "\"\nf = { type = \"ground\" }\ns = { type = \"chain\", masses = 20, mass = \"1 g\", stiffness = \"1e5 "
      "N/m\", damping "
      "= \"0.1 N s/m\" }\nbow = { type = \"motion\", position = \"1 mm * x\" }\n"
      "hair = { type = \"friction\", between = [\"bow\", \"s.3\"], normal = \"1 N\", law = \"rosin\" }\n"
      "pick = { type = \"pluck\", between = [\"bow\", \"s.9\"], stiffness = \"300 N/m\", limit = \"0.1 N\" "
      "}\n"
      "fret = { type = \"contact\", between = [\"s.15\", \"f\"], stiffness = \"1e6 N/m^1.5\", offset = "
      "\"-0.1 mm\" }\n"
      "nail = { type = \"contact\", between = [\"f\", \"s.16\"], stiffness = \"1e6 N/m^1.5\", offset = "
      "\"-0.1 mm\" }\n"
      "end = { type = \"port\", on = \"s.20\", impedance = \"1 N s/m\", wave = \"0.1 N * x\" }\n"
      "coil = { type = \"coil\", on = \"s.10\", voltage = \"1 V * x\", force_factor = \"6 T m\", resistance "
      "= \"6 ohm\", "
      "inductance = \"1 mH\" }\n[outputs]\nout = { from = \"n.end + n.fret + n.nail\", unit = \"N\", kind = "
      "\"audio\" }");
  REQUIRE(engine->prepare({48_kHz, 1, 1, 64}));
  std::vector<double> in(64), out(64);
  const double* from[] = {in.data()};
  double* to[] = {out.data()};
  double peak = 0.0;
  const auto before = allocation_count();
  for (int block = 0; block < 400; ++block) {
    for (std::size_t i = 0; i < 64; ++i)
      in[i] = std::sin(0.002 * static_cast<double>(64 * block) + 0.002 * static_cast<double>(i));
    engine->process({from, to, 64});
    for (const double y : out) peak = std::max(peak, std::abs(y));
  }
  CHECK(allocation_count() == before);
  CHECK(peak > 0.05);
  CHECK(peak < 100.0);
}

TEST_CASE("network elements: errors have place and remedy", "[physics]") {
  CHECK(element_errors("o = { type = \"oscillator\", mass = \"1 g\" }") ==
        "test.toml:4:1 Missing 'o' 'stiffness' 'frequency'");
  CHECK(element_errors("o = { type = \"oscillator\", mass = \"1 g\", stiffness = 1, frequency = 2 }") ==
        "test.toml:4:69 Duplicate 'o' 'stiffness' 'frequency'");
  CHECK(
      element_errors(
          "c = { type = \"chain\", masses = 3, mass = \"1 g\", stiffness = 1 }\np = { type = \"probe\", on = "
          "\"c.4\" }") == "test.toml:5:28 OutOfRange 'c.4' 'c' 'c.3'");
  CHECK(
      element_errors(
          "c = { type = \"chain\", masses = 3, mass = \"1 g\", stiffness = 1 }\np = { type = \"probe\", on = "
          "\"c\" }") == R"(test.toml:5:28 WrongType 'c' 'c' "c.1")");
  CHECK(element_errors("m = { type = \"mass\", mass = \"1 g\" }\np = { type = \"probe\", on = \"m.1\" }") ==
        R"(test.toml:5:28 WrongType 'm' 'm.1' "m")");
  CHECK(element_errors("c = { type = \"chain\", mass = \"1 g\", stiffness = 1 }") ==
        "test.toml:4:1 Missing 'c' 'masses' masses");
  CHECK(element_errors(
            "c = { type = \"chain\", masses = 3, ends = \"loose\", mass = \"1 g\", stiffness = 1 }") ==
        "test.toml:4:42 UnknownName 'ends' 'c' 'loose' 'fixed' 'free' 'clamped'");
  CHECK(element_errors("solver = \"exat\"\nm = { type = \"mass\", mass = \"1 g\" }") ==
        "test.toml:4:10 UnknownName 'solver' 'exat' 'exact'");
}

TEST_CASE("network elements: values that no solver can compute with are refused", "[physics]") {
  CHECK(element_errors("m = { type = \"mass\", mass = \"1 g\", at = 1e31 }") ==
        "test.toml:4:41 OutOfRange 'm.at' 'n' 1e+31 -1e+30 1e+30");
  CHECK(element_errors("c = { type = \"ring\", masses = 90001, mass = \"1 g\", stiffness = 1 }") ==
        "test.toml:4:31 OutOfRange 'masses' 'c' 90001 1 90000");
  // At 1 mm 1e20 N/m^3 turns 1 g around in 2.62 (m / K x^2)^(1/2) = 8.3 ns, 4e-4 of a step.
  const auto* const parts =
      "f = { type = \"ground\" }\nm = { type = \"mass\", mass = \"1 g\", at = \"1 mm\" }\n"
      "s = { type = \"spring\", between = [\"f\", \"m\"], stiffness = 0, cubic = 1e20 }";
  for (const auto* const solver : {"exact", "passive", "implicit"})
    CHECK(element_errors("solver = \"" + std::string{solver} + "\"\n" + parts) ==
          "test.toml:3:11 OutOfRange 'n' 'cubic' 'stiffness'");
  CHECK(element_errors(std::string{"solver = \"explicit\"\n"} + parts).empty());
}

TEST_CASE("network elements: the solver that auto takes, and why, is reported", "[physics]") {
  // Three masses between walls, k / (m fs^2) = 0.4: (w T)^2 = 0.4 * 4 sin^2(3 pi / 8) = 1.366;
  // 2 asin(w T / 2) / w T = 1.068 and 2 atan(w T / 2) / w T = 0.905.
  const auto engine = engine_of(graph(
      "solver = \"auto\"\nc = { type = \"chain\", masses = 3, mass = \"1 g\", stiffness = \"921.6 kN/m\" }",
      "n.energy / 1 J"));
  std::string about;
  for (const auto& node : engine->plan().nodes) about += node->about();
  // The solver, its cost, and of each cheaper one the error that speaks against it.
  CHECK(about.starts_with("solver exact, 36 "));
  for (const auto& [solver, error] :
       {std::pair{"explicit", "6.8 %"}, {"passive", "6.8 %"}, {"implicit", "9.5 %"}}) {
    const auto at = about.find(std::string("not ") + solver);
    REQUIRE(at != std::string::npos);
    CHECK(about.substr(at, about.find('\n', at) - at).ends_with(error));
  }
}

TEST_CASE("network elements: a choice among bad ones is reported as that, in a line for each solver",
          "[physics]") {
  // 200 masses, (w T)^2 = 4 k / (m fs^2) = 3.958: 2 atan(w T / 2) / w T = 0.787, and explicit 1.48.
  const auto describe_steps = [](const std::string& steps) {
    const auto engine = engine_of(graph("solver = \"auto\"\n" + steps +
                                            "c = { type = \"chain\", masses = 200, mass = \"1 g\", stiffness "
                                            "= \"2280 kN/m\" }",
                                        "n.energy / 1 J"));
    std::string about;
    for (const auto& node : engine->plan().nodes) about += node->about();
    return about;
  };
  const auto forced = describe_steps("oversample = 1\n");
  CHECK(forced.starts_with("solver implicit, "));
  CHECK(forced.find("21 %\n  warning: ") != std::string::npos);
  CHECK(forced.find("`oversample`") != std::string::npos);
  const auto free = describe_steps("");
  CHECK(free.starts_with("solver explicit with 8 steps per frame, "));
  CHECK(free.find("warning") == std::string::npos);
  CHECK(free.find("\n  not explicit with 4 steps per frame: ") != std::string::npos);
  CHECK(std::count(free.begin(), free.end(), '\n') <= 3);
}

TEST_CASE("network elements: no code compares the name of a type of element", "[physics]") {
  std::string names;
  for (const auto& type : network_elements()) names += (names.empty() ? "" : "|") + type.name;
  const std::regex compared("type(->|\\.)?(name)? *[!=]= *\"(" + names + ")\"|starts_with\\(\"(" + names +
                            ")\"");
  for (const auto* folder : {"engine", "apps"})
    for (const auto& file :
         std::filesystem::recursive_directory_iterator(std::string(TACTUS_SOURCE_DIR "/") + folder)) {
      if (file.path().extension() != ".cpp" && file.path().extension() != ".h") continue;
      std::ifstream in(file.path());
      std::string line;
      while (std::getline(in, line)) {
        CAPTURE(file.path(), line);
        const bool clean = !std::regex_search(line, compared);
        if (!clean) FAIL_CHECK("compare a field of the table's entry instead");
      }
    }
}
