
#include <catch2/catch.hpp>

#include "engine/dsp/filters/linear_filter.h"
#include "tests/support/measured_response.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Detail::Approx;

namespace {

constexpr double kHalfPower = -3.0102999566398120;

struct Case {
  const NodeType* type;
  std::map<std::string, InputValue> parameters;
  std::map<std::string, std::string> settings = {};
};

std::vector<Case> cases() {
  return {{&test::node_type("one_pole"), {{"cutoff", 300.0}}},
          {&test::node_type("one_pole"), {{"cutoff", 300.0}}, {{"form", "matched"}}},
          {&test::node_type("low_pass"), {{"cutoff", 3000.0}, {"q", 4.0}}},
          {&test::node_type("high_pass"), {{"cutoff", 200.0}}},
          {&test::node_type("band_pass"), {{"frequency", 1000.0}, {"q", 5.0}}},
          {&test::node_type("dc_blocker"), {{"cutoff", 40.0}}},
          {&test::node_type("velocity"), {{"cutoff", 200.0}}},
          {&test::node_type("difference"), {}},
          {&test::node_type("fir"), {}, {{"taps", "[0.5, -0.25, 0.125, 1, 0.75]"}}}};
}

NodeRunner runner_for(const Case& c, InputValue in) {
  auto inputs = c.parameters;
  inputs["in"] = std::move(in);
  return {*c.type, inputs, c.settings};
}

std::vector<double> held(const Case& c) {
  std::vector<double> at;
  for (const auto& port : c.type->inputs) {
    const auto found = c.parameters.find(port.name);
    at.push_back(found != c.parameters.end() ? std::get<double>(found->second) : port.fallback.value_or(0));
  }
  return at;
}

double stated_decibels(const NodeType& type, std::map<std::string, InputValue> parameters, double hertz,
                       int output = 0, std::map<std::string, std::string> settings = {}) {
  const Case c{&type, std::move(parameters), std::move(settings)};
  auto runner = runner_for(c, 0.0);
  return decibels(stated_response(runner, hertz, held(c), output));
}

}  // namespace

TEST_CASE("filters: the stated response is the measured one", "[nodes]") {
  constexpr int kFrames = 16384;  // the slowest pole here dies as exp(-2 pi 40 t): e-85 of it is left
  for (const auto& c : cases()) {
    INFO(c.type->name);
    auto runner = runner_for(c, impulse(kFrames));
    const auto out = runner.run(even_cutting(kFrames, 64));
    for (const double hertz : {0.0, 10.0, 100.0, 999.0, 5000.0, 15000.0, 23999.0})
      for (std::size_t o = 0; o < out.size(); ++o) {
        const auto stated = stated_response(runner, hertz, held(c), static_cast<int>(o));
        // Roundings of 16384 frames, against the largest gain that the node has: 96000 for a difference.
        CHECK(std::abs(spectrum_at(out[o], hertz) - stated) < 1e-10 * (1 + std::abs(stated)));
      }
  }
}

TEST_CASE("filters: any cutting into blocks gives the same bits", "[nodes]") {
  for (const auto& c : cases()) {
    INFO(c.type->name);
    CHECK(runner_for(c, noise(1000, 7)).cutting_matters(1000) == "");
    CHECK(runner_for(c, noise(1000, 8)).cutting_matters(1000, 2, 1000003) == "");
    CHECK(runner_for(c, -1.0).cutting_matters(100) == "");
  }
}

TEST_CASE("filters: modulated parameters keep the bits for any cutting, and the output finite", "[nodes]") {
  for (const auto& c : cases()) {
    if (c.type->inputs.size() < 2) continue;
    INFO(c.type->name);
    auto modulated = c;
    modulated.parameters[c.type->inputs[1].name] = noise(2000, 9, -1000, 40000);  // beyond what is valid
    auto runner = runner_for(modulated, noise(2000, 10));
    CHECK(runner.cutting_matters(2000) == "");
    const auto out = runner.run(even_cutting(2000, 64));
    for (const double y : out[0]) REQUIRE(std::isfinite(y));
  }
}

TEST_CASE("filters: a parameter held in samples is a constant parameter", "[nodes]") {
  for (const auto& c : cases()) {
    if (c.type->inputs.size() < 2) continue;
    INFO(c.type->name);
    auto in_samples = c;
    auto& parameter = in_samples.parameters[c.type->inputs[1].name];
    parameter = Samples(500, std::get<double>(parameter));
    const auto lengths = even_cutting(500, 37);
    CHECK(first_difference(runner_for(c, noise(500, 4)).run(lengths),
                           runner_for(in_samples, noise(500, 4)).run(lengths)) == "");
  }
}

TEST_CASE("filters: cutoffs from 0 to beyond the rate, and NaN, are made designable", "[nodes]") {
  const double cutoff = GENERATE(0.0, -5.0, 1e-30, 24000.0, 1e9, std::numeric_limits<double>::quiet_NaN());
  for (auto c : cases()) {
    if (c.type->inputs.size() < 2) continue;
    INFO(c.type->name << " at " << cutoff);
    c.parameters[c.type->inputs[1].name] = cutoff;
    const auto out = runner_for(c, noise(1000, 5)).run(even_cutting(1000, 64));
    for (const double y : out[0]) REQUIRE(std::isfinite(y));
  }
}

TEST_CASE("one_pole: the matched form is at -3.01 dB at the cutoff too", "[nodes]") {
  const auto cutoff = GENERATE(80.0, 3000.0, 10000.0);
  CHECK(stated_decibels(test::node_type("one_pole"), {{"cutoff", cutoff}}, cutoff, 0,
                        {{"form", "matched"}}) == Approx(kHalfPower).margin(1e-9));
}

TEST_CASE("one_pole: both outputs are at -3.01 dB at the cutoff and add up to the input", "[nodes]") {
  const double cutoff = GENERATE(40.0, 250.0, 6000.0, 20000.0);
  CHECK(stated_decibels(test::node_type("one_pole"), {{"cutoff", cutoff}}, cutoff, 0) ==
        Approx(kHalfPower).margin(1e-9));
  CHECK(stated_decibels(test::node_type("one_pole"), {{"cutoff", cutoff}}, cutoff, 1) ==
        Approx(kHalfPower).margin(1e-9));
}

TEST_CASE("low_pass, high_pass: gain q at the cutoff, 1 in the passband", "[nodes]") {
  const double q = GENERATE(0.5, 0.7071067811865476, 8.0);
  const double cutoff = GENERATE(30.0, 3000.0, 20000.0);
  const std::map<std::string, InputValue> parameters{{"cutoff", cutoff}, {"q", q}};
  CHECK(stated_decibels(test::node_type("low_pass"), parameters, cutoff) ==
        Approx(20 * std::log10(q)).margin(1e-6));
  CHECK(stated_decibels(test::node_type("high_pass"), parameters, cutoff) ==
        Approx(20 * std::log10(q)).margin(1e-6));
  CHECK(stated_decibels(test::node_type("low_pass"), parameters, 0) == Approx(0).margin(1e-8));
  CHECK(stated_decibels(test::node_type("high_pass"), parameters, 24000) == Approx(0).margin(1e-8));
}

TEST_CASE("low_pass: Butterworth falls as 1 / sqrt(1 + (f/fc)^4) on the prewarped axis", "[nodes]") {
  const double hertz = GENERATE(100.0, 1000.0, 3000.0, 6000.0, 12000.0);
  const auto warped = [](double f) { return std::tan(std::numbers::pi * f / 48000); };
  const double ratio = warped(hertz) / warped(3000);
  CHECK(stated_decibels(test::node_type("low_pass"), {{"cutoff", 3000.0}}, hertz) ==
        Approx(-10 * std::log10(1 + std::pow(ratio, 4))).margin(1e-8));
}

TEST_CASE("band_pass: 0 dB at its frequency, -3.01 dB at its edges", "[nodes]") {
  const double q = GENERATE(1.0, 20.0);
  const std::map<std::string, InputValue> parameters{{"frequency", 2000.0}, {"q", q}};
  CHECK(stated_decibels(test::node_type("band_pass"), parameters, 2000) == Approx(0).margin(1e-10));
  // Half power where s - 1/s = 1/q, on the prewarped axis s = tan(w/2) / tan(w0/2).
  const double edge = 1 / (2 * q) + std::sqrt(1 / (4 * q * q) + 1);
  const double hertz = std::atan(edge * std::tan(std::numbers::pi * 2000 / 48000)) * 48000 / std::numbers::pi;
  CHECK(stated_decibels(test::node_type("band_pass"), parameters, hertz) == Approx(kHalfPower).margin(1e-6));
}

TEST_CASE("high_pass: a constant dies away to nothing, without the roundings of a low cutoff", "[nodes]") {
  NodeRunner runner{test::node_type("high_pass"), {{"in", 1.0}, {"cutoff", 10.0}}};
  const auto out = runner.run(even_cutting(96000, 64));
  // exp(-2 pi 10 0.7071 2 s) = 1e-39 of the start is left.
  CHECK(std::abs(out[0].back()) < 1e-30);
}

TEST_CASE("dc_blocker: y = p (y1 + x - x1)", "[nodes]") {
  const double p = 1 / (1 + 2 * std::numbers::pi * 10 / 48000);
  const auto x = noise(500, 3);
  NodeRunner runner{test::node_type("dc_blocker"), {{"in", x}}};
  const auto y = runner.run(even_cutting(500, 64))[0];
  double y1 = 0, x1 = 0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    y1 = p * (y1 + x[n] - x1);
    x1 = x[n];
    REQUIRE(y[n] == Approx(y1).margin(1e-13));
  }
}

TEST_CASE("dc_blocker: within 1 % of half power at the cutoff below fs/600", "[nodes]") {
  const double cutoff = GENERATE(1.0, 10.0, 80.0);
  CHECK(std::pow(10, stated_decibels(test::node_type("dc_blocker"), {{"cutoff", cutoff}}, cutoff) / 20) ==
        Approx(std::sqrt(0.5)).epsilon(0.01));
}

TEST_CASE("difference: a ramp gives its slope from the first step on", "[nodes]") {
  Samples ramp(100);
  for (std::size_t n = 0; n < ramp.size(); ++n) ramp[n] = 0.25 * static_cast<double>(n) / 48000;
  NodeRunner runner{test::node_type("difference"), {{"in", ramp}}};
  const auto out = runner.run(even_cutting(100, 64))[0];
  for (std::size_t n = 1; n < out.size(); ++n) CHECK(out[n] == Approx(0.25).epsilon(1e-12));
}

TEST_CASE("velocity: a ramp gives its slope, and the low-pass is at -3.01 dB at the cutoff", "[nodes]") {
  const double cutoff = GENERATE(20.0, 200.0, 5000.0, 20000.0);
  Samples ramp(48000);
  for (std::size_t n = 0; n < ramp.size(); ++n) ramp[n] = 0.25 * static_cast<double>(n) / 48000;
  NodeRunner runner{test::node_type("velocity"), {{"in", ramp}, {"cutoff", cutoff}}};
  // After a second the start, exp(-2 pi 20), is gone; positions of 0.25 m carry 3e-17 m of rounding, times
  // 48000/s.
  CHECK(runner.run(even_cutting(48000, 64))[0].back() == Approx(0.25).epsilon(1e-10));
  const double low_pass = stated_decibels(test::node_type("velocity"), {{"cutoff", cutoff}}, cutoff) -
                          stated_decibels(test::node_type("difference"), {}, cutoff);
  CHECK(low_pass == Approx(kHalfPower).margin(1e-8));
}

TEST_CASE("fir: the impulse response is the taps", "[nodes]") {
  NodeRunner runner{test::node_type("fir"), {{"in", impulse(40)}}, {{"taps", "[1, -2, \"50 %\", 4]"}}};
  const auto out = runner.run(even_cutting(40, 7))[0];
  const Samples expected{1, -2, 0.5, 4};
  for (std::size_t n = 0; n < out.size(); ++n) CHECK(out[n] == (n < expected.size() ? expected[n] : 0.0));
}

TEST_CASE("fir: no taps is an error", "[nodes]") {
  const NodeRunner runner{test::node_type("fir"), {{"in", 0.0}}, {{"taps", "[]"}}};
  CHECK(runner.error() == "OutOfRange 'taps'");
}
