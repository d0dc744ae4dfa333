#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/play_node.h"
#include "tests/support/measured_response.h"

using namespace tactus;
using namespace tactus::test;

TEST_CASE("waveguide: without gain it is endless and nothing comes back", "[nodes]") {
  CHECK(play_node(test::node_type("waveguide"), 3000,
                  {{"wave", noise(3000, 1)}, {"pitch", 100.0}, {"gain", 0.0}}) == Samples(3000, 0.0));
}

TEST_CASE("waveguide: a whole number of frames comes back as it went, upside down from a free end",
          "[nodes]") {
  const auto [end, sign] = GENERATE(table<std::string, double>({{"fixed", 1}, {"free", -1}}));
  // 480 frames around, one of which is the port's.
  const auto output = play_node(
      test::node_type("waveguide"), 2000,
      {{"wave", impulse(2000)}, {"pitch", 48000 / 480.0}, {"gain", 0.75}, {"loss", 0.0}}, {{"end", end}});
  for (std::size_t n = 0; n < output.size(); ++n)
    CHECK(output[n] == Approx(n == 479 ? sign * 0.75 : 0).epsilon(0).margin(1e-12));
}

TEST_CASE("waveguide and string: a pitch beyond the range is its end, at every rate", "[nodes]") {
  const auto [type, input] =
      GENERATE(table<std::string, std::string>({{"waveguide", "wave"}, {"string", "in"}}));
  const auto rate = GENERATE(48_kHz, 192_kHz);
  const auto play = [&, type = type, input = input](double pitch) {
    NodeRunner runner(test::node_type(type), {{input, noise(500, 1)}, {"pitch", Samples(500, pitch)}}, {},
                      rate);
    return runner.run(even_cutting(500, kLongestSubBlock))[0];
  };
  CHECK(play(1e300) == play(20e3));
  CHECK(play(20e3 + 1) == play(20e3));
  CHECK(play(-1) == play(10));
}

TEST_CASE("modal_body: listed masses keep their ratio, and each is felt", "[nodes]") {
  // Far above its modes a body is a mass of 1 / sum of 1/m; at 10 kHz the bilinear s is 2 fs j tan(w / 2).
  const double hertz = 10000, s = 2 * 48000 * std::tan(std::numbers::pi * hertz / 48000);
  const auto give = [&](std::map<std::string, InputValue> inputs) {
    inputs["wave"] = 0.0;
    inputs["impedance"] = 1e-6;
    NodeRunner body(test::node_type("modal_body"), inputs,
                    {{"frequencies", "[50, 60]"}, {"masses", "[0.1, 0.3]"}});
    const auto velocity =
        body.node().response(0, 1, on_circle(Hertz{hertz}, 48_kHz), std::vector<double>{0, 1e-6, 0, 1, 1});
    return std::abs(*velocity) / 2 * s;
  };
  CHECK(give({}) == Approx(1 / 0.1 + 1 / 0.3).epsilon(1e-4));
  CHECK(give({{"mass", 0.02}}) == Approx(1 / 0.02 + 1 / 0.06).epsilon(1e-4));
}

TEST_CASE("modal_body: it says what does not fit", "[nodes]") {
  const auto said = [](std::map<std::string, std::string> settings) {
    return refusal(test::node_type("modal_body"), {{"wave", 0.0}, {"impedance", 1.0}}, settings);
  };
  CHECK(said({{"frequencies", "[100, 200]"}, {"masses", "[1, 0]"}}) == "OutOfRange 'masses' 0");
  CHECK(said({{"frequencies", "[100, 200]"}, {"masses", "[1, 2, 3]"}}) == "OutOfRange 'masses' 3 2");
}
