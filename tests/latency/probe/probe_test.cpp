#include "latency/probe/probe.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

using namespace tactus;

TEST_CASE("probe: a sweep runs from its first to its last frequency, in equal times for equal ratios",
          "[latency]") {
  const auto rate = GENERATE(44.1_kHz, 48_kHz, 96_kHz, 192_kHz);
  const auto sweep = measuring_probe(rate);
  const auto samples = sweep.samples(rate);
  CHECK(static_cast<double>(samples.size()) == Approx(0.35 * rate.value).epsilon(0).margin(1));
  // Zero crossings from t1 to t2 are 2 start growth (exp(t2 / growth) - exp(t1 / growth)).
  const double growth = sweep.growth().value;
  const auto crossings = [&](double from, double to) {
    int count = 0;
    for (auto n = static_cast<std::size_t>(from * rate.value);
         n + 1 < static_cast<std::size_t>(to * rate.value); ++n)
      count += samples[n] * samples[n + 1] < 0.0;
    return count;
  };
  for (const double from : {0.05, 0.15, 0.3}) {
    const double expected =
        2 * sweep.start.value * growth * (std::exp((from + 0.04) / growth) - std::exp(from / growth));
    CHECK(crossings(from, from + 0.04) == Approx(expected).epsilon(0).margin(2.0));
  }
  CHECK(sweep.start.value * std::exp(sweep.duration.value / growth) == Approx(0.42 * rate.value));
}

TEST_CASE("probe: nothing in it is louder than it says", "[latency]") {
  const auto samples = stimulus(48_kHz, 0.25);
  const auto loudest = [](const std::vector<double>& all) {
    return std::abs(*std::max_element(all.begin(), all.end(),
                                      [](double a, double b) { return std::abs(a) < std::abs(b); }));
  };
  CHECK(loudest(samples) == Approx(0.25).epsilon(0.001));
  CHECK(loudest(pilot(48_kHz)) <= 1.0);
}

TEST_CASE("bursts: a stimulus is taken apart into eight sweeps and a pilot", "[latency]") {
  const auto samples = stimulus(48_kHz, 0.25);
  const auto bursts = find_bursts(samples, 48_kHz);
  REQUIRE(bursts);
  REQUIRE(bursts->repeated.size() == ProbeTrain::kProbes);
  std::vector<std::int64_t> distances;
  for (int k = 0; k < ProbeTrain::kProbes; ++k) {
    const auto& burst = bursts->repeated[static_cast<std::size_t>(k)];
    CHECK(burst.gain == Approx(ProbeTrain::gain(k)).epsilon(1e-6));
    for (int before = 0; before < k; ++before)
      distances.push_back(burst.at - bursts->repeated[static_cast<std::size_t>(before)].at);
  }
  // No two pairs are equally far apart, so the train fits itself only where it is.
  std::sort(distances.begin(), distances.end());
  CHECK(std::adjacent_find(distances.begin(), distances.end()) == distances.end());
  CHECK(bursts->pilot(48_kHz));
  CHECK(bursts->peak == Approx(0.25).epsilon(0.001));
}

TEST_CASE("probe: it begins with a mark, whose every part differs from the others", "[latency]") {
  const auto rate = GENERATE(44.1_kHz, 48_kHz, 192_kHz);
  const auto samples = stimulus(rate, 0.25);
  const auto mark = find_bursts(samples, rate)->mark(rate);
  REQUIRE(mark);
  // Of its edges of 0.3 ms the first and last twentieth are below the silence of a converter.
  CHECK(static_cast<double>(mark->at) <= 1.0 + 2e-5 * rate.value);
  CHECK(static_cast<double>(mark->frames) == Approx(0.03 * rate.value).epsilon(0).margin(1e-4 * rate.value));
  // Moved by a few frames, no part of it is like itself: a frame that is lost within it shows.
  for (std::size_t from = 64; from + 512 < static_cast<std::size_t>(mark->frames); from += 256)
    for (std::size_t lag = 3; lag < 64; ++lag) {
      double common = 0.0, power = 0.0;
      for (std::size_t n = from; n < from + 256; ++n) {
        common += samples[n] * samples[n + lag];
        power += samples[n] * samples[n];
      }
      CHECK(std::abs(common) < 0.6 * power);
    }
}

TEST_CASE("bursts: a signal without a mark has none", "[latency]") {
  auto samples = stimulus(48_kHz, 0.25);
  std::fill_n(samples.begin(), 20000, 0.0);
  CHECK_FALSE(find_bursts(samples, 48_kHz)->mark(48_kHz));
}

TEST_CASE("bursts: a recording of any other signal between pauses will do, and silence will not",
          "[latency]") {
  std::vector<double> samples(40000, 0.0);
  for (const int at : {5000, 15000, 30000})
    for (int n = 0; n < 3000; ++n)
      samples[static_cast<std::size_t>(at + n)] = (at == 15000 ? -0.1 : 0.2) * std::sin(0.001 * n * n);
  const auto bursts = find_bursts(samples, 48_kHz);
  REQUIRE(bursts);
  REQUIRE(bursts->repeated.size() == 3);
  CHECK(bursts->repeated[1].gain == Approx(-0.5).epsilon(1e-6));
  CHECK(bursts->others.empty());
  CHECK_FALSE(find_bursts(std::vector<double>(1000, 0.0), 48_kHz));
}
