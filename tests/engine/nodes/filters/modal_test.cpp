#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/play_node.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kRate = 48000;

double damped_sine(double gain, double hertz, double decay, std::size_t frame) {
  const double t = static_cast<double>(frame) / kRate;
  return gain * std::pow(1e-3, t / decay) * std::sin(2 * std::numbers::pi * hertz * t);
}

struct Partial {
  double hertz, decay, gain;
};

double worst_error(const Samples& output, const std::vector<Partial>& expected) {
  double worst = 0;
  for (std::size_t n = 0; n < output.size(); ++n) {
    double sum = 0;
    for (const auto& mode : expected) sum += damped_sine(mode.gain, mode.hertz, mode.decay, n);
    worst = std::max(worst, std::abs(output[n] - sum));
  }
  return worst;
}

}  // namespace

TEST_CASE("modal: listed modes ring as they are listed", "[nodes]") {
  const auto output = play_node(test::node_type("modal"), 24000, {{"in", impulse(24000)}},
                                {{"frequencies", "[220 Hz, 0.61 kHz, 1203 Hz]"},
                                 {"decays", "[1 s, 500 ms, 0.2]"},
                                 {"gains", "[1, -0.5, 0.25]"}});
  CHECK(worst_error(output, {{220, 1, 1}, {610, 0.5, -0.5}, {1203, 0.2, 0.25}}) < 1e-9);
}

TEST_CASE("modal: frequency and decay move all listed modes together", "[nodes]") {
  const auto output = play_node(test::node_type("modal"), 24000,
                                {{"in", impulse(24000)}, {"frequency", 110.0}, {"decay", 0.5}},
                                {{"frequencies", "[220, 610]"}, {"decays", "[1, 0.5]"}});
  CHECK(worst_error(output, {{110, 0.5, 1}, {305, 0.25, 1}}) < 1e-9);
}

TEST_CASE("modal: a series has the ratios, decays and gains that it says", "[nodes]") {
  const auto output = play_node(test::node_type("modal"), 24000,
                                {{"in", impulse(24000)}, {"frequency", 200.0}, {"decay", 0.8}},
                                {{"series", "harmonic"},
                                 {"modes", "3"},
                                 {"decay_slope", "1"},
                                 {"gain_slope", "2"},
                                 {"gains", "[0.5]"}});
  CHECK(worst_error(output, {{200, 0.8, 0.5}, {400, 0.4, 0.125}, {600, 0.8 / 3, 0.5 / 9}}) < 1e-9);
}

TEST_CASE("modal: a series without settings has those of the reference: slope 0.5, 16 modes up to 16 times",
          "[nodes]") {
  const auto engine = engine_of(
      "format = 1\n[inputs]\nx = {}\n[nodes]\n"
      "y = { type = \"modal\", in = \"x\", series = \"geometric\", frequency = \"200 Hz\", decay = \"0.8 s\" "
      "}\n"
      "[outputs]\nout = { from = \"y\" }\n");
  const auto output = run(*engine, {impulse(6000)}, 6000, {64})[0];
  std::vector<Partial> expected;
  for (int k = 0; k < 16; ++k) {
    const double ratio = std::pow(16.0, k / 15.0);
    expected.push_back({200 * ratio, 0.8 / std::sqrt(ratio), 1});
  }
  CHECK(worst_error(output, expected) < 1e-9);
}

TEST_CASE("modal: a mode that rings is retuned at the next group of eight frames, in phase", "[nodes]") {
  constexpr int kFrames = 400, kChange = 101, kRetuned = 104;
  Samples frequency(kFrames, 1000.0);
  std::fill(frequency.begin() + kChange, frequency.end(), 3000.0);
  const auto y =
      play_node(test::node_type("modal"), kFrames,
                {{"in", impulse(kFrames)}, {"frequency", frequency}, {"decay", 1.0}}, {{"modes", "1"}});
  double turned = 0;
  for (std::size_t n = 0; n < kFrames; ++n) {
    CHECK(y[n] ==
          Approx(std::pow(1e-3, static_cast<double>(n) / kRate) * std::sin(turned)).epsilon(0).margin(1e-12));
    turned += 2 * std::numbers::pi * (n + 1 < kRetuned ? 1000 : 3000) / kRate;
  }
}

TEST_CASE("modal: no movement of its frequency makes it louder", "[nodes]") {
  constexpr int kFrames = 9600;
  const auto output =
      play_node(test::node_type("modal"), kFrames,
                {{"in", impulse(kFrames)}, {"frequency", noise(kFrames, 5, 20, 8000)}, {"decay", 1.0}},
                {{"modes", "1"}});
  double most = 0;
  for (std::size_t n = 0; n < kFrames; ++n)
    most = std::max(most, std::abs(output[n]) * std::pow(1e3, static_cast<double>(n) / kRate));
  CHECK(most <= 1 + 1e-9);
  CHECK(most > 0.99);
}

// y[n] = a1 y[n-1] + a2 y[n-2] + b (x[n-1] + g y[n-1]): the loop moves the pole, and is one frame long.
TEST_CASE("modal: it closes a loop without a delay node", "[nodes]") {
  const auto engine = engine_of(
      "format = 1\n[inputs]\nx = {}\n[nodes]\n"
      "y = { type = \"modal\", in = \"x - 0.3 * y\", frequency = \"500 Hz\", modes = 1, decay = \"0.1 s\" }\n"
      "[outputs]\nout = { from = \"y\" }\n");
  const auto output = run(*engine, {impulse(3000)}, 3000, {64, 7})[0];
  const double w = 2 * std::numbers::pi * 500 / kRate, r = std::pow(1e-3, 1 / (0.1 * kRate));
  const double b = r * std::sin(w), a1 = 2 * r * std::cos(w) - 0.3 * b, a2 = -r * r;
  double last = 0, before = 0, worst = 0;
  for (std::size_t n = 0; n < output.size(); ++n) {
    const double now = a1 * last + a2 * before + (n == 1 ? b : 0);
    worst = std::max(worst, std::abs(output[n] - now));
    before = last, last = now;
  }
  CHECK(worst < 1e-11);
  CHECK(std::abs(output[500]) > 1e-3);
}

TEST_CASE("modal: it says what does not fit", "[nodes]") {
  const auto said = [](std::map<std::string, std::string> settings) {
    return refusal(test::node_type("modal"), {{"in", 0.0}}, settings);
  };
  CHECK(said({{"frequencies", "[100, 200]"}, {"gains", "[1, 2, 3]"}}) == "OutOfRange 'gains' 3 2");
  CHECK(said({{"frequencies", "[100, 200]"}, {"decays", "[]"}}) == "OutOfRange 'decays' 0 2");
  CHECK(said({{"frequencies", "[100]"}, {"series", "bar"}}) == "OutOfRange 'frequencies' 'series'");
  CHECK(said({{"frequencies", "[100, 0]"}}) == "OutOfRange 'frequencies' 1");
  CHECK(said({{"frequencies", "[]"}}) == "OutOfRange 'frequencies' 0 1 4096");
}
