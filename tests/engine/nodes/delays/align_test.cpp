#include <catch2/catch.hpp>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/measured_response.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kRate = 48000;

NodeRunner align_of(InputValue in, std::map<std::string, InputValue> others) {
  others["in"] = std::move(in);
  return {test::node_type("align"), std::move(others)};
}

/// Frames that an impulse is late: where its energy lies.
double lateness(const Samples& y) {
  double sum = 0, moment = 0;
  for (std::size_t n = 0; n < y.size(); ++n) sum += y[n], moment += y[n] * static_cast<double>(n);
  return moment / sum;
}

}  // namespace

TEST_CASE("align: pad and delay together are whole periods, with the least pad of a frame or more",
          "[nodes]") {
  const double hertz = GENERATE(65.4, 110.0, 441.3, 987.7);
  const double delay_ms = GENERATE(0.0, 1.0, 5.0, 10.0, 20.37, 40.0);
  INFO(hertz << " Hz, " << delay_ms << " ms");
  auto runner = align_of(impulse(2000), {{"period", 1 / hertz}, {"delay", delay_ms * 1e-3}});
  const double pad_s = lateness(runner.run(even_cutting(2000, 64))[0]) / kRate;
  const double periods = (pad_s + delay_ms * 1e-3) * hertz;
  // The interpolator's polynomial keeps the first moment of an impulse exactly.
  CHECK(periods == Approx(std::round(periods)).epsilon(0).margin(1e-9));
  CHECK(pad_s * kRate >= 1 - 1e-9);
  CHECK(pad_s < 1 / hertz + 1.000001 / kRate);
}

TEST_CASE("align: a phase that lags counts as delay", "[nodes]") {
  const double hertz = 220, phase = GENERATE(-3.14159265, -1.0, 0.5);
  auto runner = align_of(impulse(2000), {{"period", 1 / hertz}, {"delay", 0.02}, {"phase", phase}});
  const double turns = lateness(runner.run(even_cutting(2000, 64))[0]) / kRate * hertz + 0.02 * hertz -
                       phase / (2 * std::numbers::pi);
  CHECK(turns == Approx(std::round(turns)).epsilon(0).margin(1e-9));
}

TEST_CASE("align: the stated response is the measured one", "[nodes]") {
  auto runner = align_of(impulse(2000), {{"period", 1 / 311.1}, {"delay", 0.0183}});
  const auto y = runner.run(even_cutting(2000, 64))[0];
  for (const double hertz : {0.0, 311.1, 3000.0, 11000.0})
    CHECK(std::abs(spectrum_at(y, hertz) - stated_response(runner, hertz, {0, 1 / 311.1, 0.0183, 0, 0, 1})) <
          1e-12);
}

TEST_CASE("align: switched off it is a copy, bit for bit", "[nodes]") {
  const auto x = noise(3000, 1);
  auto runner = align_of(x, {{"period", 1 / 220.0}, {"delay", 0.02}, {"on", 0.0}});
  CHECK(runner.run(random_cutting(3000, 1))[0] == x);
}

TEST_CASE("align: a vibrato leaves no step where the number of periods changes", "[nodes]") {
  // 40 ms are 17.6 periods of 440 Hz: 3 % of them are half a period up and down.
  Samples x(48000), period(48000);
  for (std::size_t n = 0; n < x.size(); ++n) {
    const double t = static_cast<double>(n) / kRate;
    period[n] = (1 + 0.05 * std::sin(2 * std::numbers::pi * 5 * t)) / 440;
    x[n] = std::sin(2 * std::numbers::pi * 440 * t);
  }
  auto runner = align_of(x, {{"period", period}, {"delay", 0.04}});
  const auto y = runner.run(random_cutting(48000, 2))[0];
  // A tap that moves by 18 periods times 5 % 2 pi 5 Hz plays 6.5 % sharp or flat; a fade adds 1 / 10 ms.
  const double steepest = 2 * std::numbers::pi * 440 / kRate * 1.07 + 2 / (0.010 * kRate);
  for (std::size_t n = 2500; n < y.size(); ++n) REQUIRE(std::abs(y[n] - y[n - 1]) < steepest);
}

TEST_CASE("align: a new note finds its own pad at once, and within 10 ms nothing is left of the old one",
          "[nodes]") {
  const bool by_trigger = GENERATE(true, false);
  Samples period(4800, 1 / 220.0), trigger(4800, 0.0), x(4800, 0.0);
  for (std::size_t n = 2400; n < period.size(); ++n) period[n] = 1 / (by_trigger ? 224.0 : 330.0);
  trigger[2400] = by_trigger ? 1 : 0;
  x[2400 + 500] = 1;
  auto runner = align_of(x, {{"period", period}, {"delay", 0.02}, {"trigger", trigger}});
  const auto y = runner.run(even_cutting(4800, 64))[0];
  const double pad = lateness({y.begin() + 2900, y.end()});
  const double periods = (pad / kRate + 0.02) / period.back();
  CHECK(periods == Approx(std::round(periods)).epsilon(0).margin(1e-9));
  CHECK(pad < period.back() * kRate + 1.000001);
}

TEST_CASE("align: filters that are named count with their phase, and so do models that nothing reads",
          "[nodes]") {
  const auto engine = engine_of(R"(
format = 1
[inputs]
x = {}
[nodes]
tone  = { type = "low_pass", in = "x", cutoff = "500 Hz" }
pad   = { type = "align", in = "tone", period = "1 / 250 Hz", delay = "20 ms", compensate = ["tone", "plant"] }
plant = { type = "low_pass", in = "pad", cutoff = "40 Hz", q = 1.5 }
[outputs]
y = { from = "pad" }
)");
  const auto y = run(*engine, {impulse(4800)}, 4800, {64})[0];
  const double seen = std::arg(spectrum_at(y, 250) * std::polar(1.0, -2 * std::numbers::pi * 250 * 0.02));
  // What is missing to a whole turn is the plant's: 1 / (1 - (f/f0)^2 + j f / (f0 q)), 250 Hz over 40 Hz,
  // warped by the bilinear transform by (pi 250 / 48000)^2 / 3 = 1e-4.
  const double r = 250.0 / 40;
  CHECK(seen == Approx(std::numbers::pi - std::atan(r / 1.5 / (r * r - 1))).epsilon(0).margin(1e-3));
}
