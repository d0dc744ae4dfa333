#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/units.h"
#include "engine/dsp/delays/resample.h"
#include "tests/support/measured_response.h"

using namespace tactus;
using namespace tactus::test;

namespace {

Samples one_tap(std::size_t at) {
  Samples taps(at + 1);
  taps[at] = 1;
  return taps;
}

/// A mass on a spring of 200 Hz and Q 5, pushed once `late` seconds after the beginning; as many seconds of
/// it that the rest is below 1e-6.
Samples resonator(Hertz rate, double late) {
  const double w = 2 * kPi * 200, decay = w / (2 * 5);
  Samples taps;
  for (double t = -late; t < 14 / decay; t += 1 / rate.value)
    taps.push_back(t < 0 ? 0 : std::exp(-decay * t) * std::sin(w * t));
  return taps;
}

/// Largest deviation of the responses between 10 Hz and `to`.
struct Deviation {
  double decibels = 0, degrees = 0;
};

Deviation deviation(const Samples& before, Hertz from, const Samples& after, Hertz rate, double to) {
  Deviation worst;
  for (double f = 10; f <= to; f *= 1.05) {
    const auto ratio = spectrum_at(after, f, rate.value) / spectrum_at(before, f, from.value);
    worst.decibels = std::max(worst.decibels, std::abs(decibels(ratio)));
    worst.degrees = std::max(worst.degrees, std::abs(std::arg(ratio)) * 180 / kPi);
  }
  return worst;
}

struct Rates {
  Hertz from, to;
};

Rates rates() {
  return GENERATE(Rates{96_kHz, 48_kHz}, Rates{48_kHz, 96_kHz}, Rates{44.1_kHz, 48_kHz},
                  Rates{48_kHz, 44.1_kHz}, Rates{192_kHz, 44.1_kHz}, Rates{48_kHz, 47.9173_kHz});
}

}  // namespace

TEST_CASE("taps_at_rate: the same rate keeps every bit", "[dsp]") {
  const auto taps = noise(300, 5);
  CHECK(taps_at_rate(taps, 44.1_kHz, 44.1_kHz) == taps);
}

TEST_CASE("taps_at_rate: what comes after 5 ms keeps its response up to 0.4 of the lower rate", "[dsp]") {
  const auto [from, to] = rates();
  CAPTURE(from.value, to.value);
  const double edge = 0.4 * std::min(from.value, to.value);
  const auto late = static_cast<std::size_t>(0.005 * from.value);
  for (const auto& taps : {one_tap(late), resonator(from, 0.005)}) {
    const auto worst = deviation(taps, from, taps_at_rate(taps, from, to), to, edge);
    CHECK(worst.decibels < 0.1);
    CHECK(worst.degrees < 1);
  }
}

TEST_CASE("taps_at_rate: what begins at once keeps its response up to 0.2 of the lower rate", "[dsp]") {
  const auto [from, to] = rates();
  CAPTURE(from.value, to.value);
  for (const auto& taps : {one_tap(0), one_tap(1), resonator(from, 0)}) {
    CAPTURE(taps.size());
    const auto after = taps_at_rate(taps, from, to);
    const auto worst = deviation(taps, from, after, to, 0.2 * std::min(from.value, to.value));
    CHECK(worst.decibels < 0.1);
    CHECK(worst.degrees < 1);
    if (taps.size() > 2) continue;
    // No gain above that pays for it: a tap alone has gain 1 everywhere.
    for (double f = 0; f < to.value / 2; f += 100) CHECK(std::abs(spectrum_at(after, f, to.value)) < 1.7);
  }
}

TEST_CASE("taps_at_rate: nothing appears above the Nyquist frequency of the measurement", "[dsp]") {
  const auto after = taps_at_rate(one_tap(300), 48_kHz, 96_kHz);
  for (double f = 24e3; f < 48e3; f += 100) CHECK(decibels(spectrum_at(after, f, 96000)) < -90);
}

TEST_CASE("taps_at_rate: never more taps than announced", "[dsp]") {
  const auto [from, to] = rates();
  for (const int count : {1, 2, 17, 300}) {
    const auto taps = noise(count, 3);
    CHECK(taps_at_rate(taps, from, to).size() <= length_at_rate(taps.size(), from, to));
  }
}
