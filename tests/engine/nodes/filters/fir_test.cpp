#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/dsp/delays/resample.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/measured_response.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Detail::Approx;

namespace {

/// A graph of one fir node, its taps ten a line.
std::string graph(const Samples& taps, const std::string& rate) {
  std::string text = "format = 1\n[inputs]\ndrive = {}\n[nodes.path]\ntype = \"fir\"\nin = \"drive\"\n" +
                     (rate.empty() ? "" : "rate = \"" + rate + "\"\n") + "taps = [";
  for (std::size_t k = 0; k < taps.size(); ++k)
    text += fmt::format("{}{}, ", k % 10 == 0 ? "\n" : "", taps[k]);
  return text + "\n]\n[outputs]\nsensor = { from = \"path\" }\n";
}

Samples answer(const Samples& taps, const std::string& rate, Hertz engine_rate, int frames) {
  CompileOptions options;
  options.sample_rate = engine_rate;
  const auto engine = engine_of(graph(taps, rate), options);
  return run(*engine, {impulse(frames)}, frames, {64})[0];
}

}  // namespace

TEST_CASE("fir: 12000 taps over many lines are the impulse response bit for bit, with their rate and without",
          "[nodes]") {
  const auto taps = noise(12000, 7);
  const auto rate = GENERATE("", "48 kHz");
  CHECK(answer(taps, rate, 48_kHz, 12000) == taps);
}

TEST_CASE("fir: at another rate than that of its taps it runs what they become there", "[nodes]") {
  const auto taps = noise(50, 9);
  auto expected = taps_at_rate(taps, 96_kHz, 44.1_kHz);
  expected.resize(300);
  CHECK(answer(taps, "96 kHz", 44.1_kHz, 300) == expected);
}

TEST_CASE("fir: at another rate it states the response that it has", "[nodes]") {
  NodeRunner runner{
      test::node_type("fir"), {{"in", impulse(400)}}, {{"taps", "[0.5, -0.25, 1]"}, {"rate", "96 kHz"}}};
  const auto output = runner.run(even_cutting(400, 64))[0];
  for (const double f : {10.0, 1000.0, 20000.0}) {
    const auto stated = stated_response(runner, f, {0});
    CHECK(std::abs(stated - spectrum_at(output, f)) < 1e-12);
  }
}

TEST_CASE("fir: a rate that no measurement has is an error", "[nodes]") {
  const Samples taps{1, 2};
  CHECK(errors_of(graph(taps, "48 Hz")) == "test.toml:7:8 OutOfRange 'rate' 'path' 48 1 1000");
  CHECK(errors_of(graph(taps, "48 ms")) == R"(test.toml:7:8 UnitMismatch '48 ms' 'rate' "440 Hz")");
}
