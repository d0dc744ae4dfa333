#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "apps/render/render.h"

using namespace tactus;

namespace {

Samples sine(double frequency_hz, Hertz rate, std::int64_t frames) {
  Samples samples{rate, {{}}};
  for (std::int64_t n = 0; n < frames; ++n)
    samples.channels[0].push_back(
        std::sin(2 * std::numbers::pi * frequency_hz * static_cast<double>(n) / rate.value));
  return samples;
}

double db(double amplitude) { return 20 * std::log10(amplitude); }

/// Largest |a - b| away from the ends, where the kernel reaches beyond the samples.
double largest_difference(const Samples& a, const Samples& b) {
  constexpr std::size_t kEnds = 500;
  double largest = 0;
  for (std::size_t n = kEnds; n + kEnds < a.channels[0].size(); ++n)
    largest = std::max(largest, std::abs(a.channels[0][n] - b.channels[0][n]));
  return largest;
}

}  // namespace

TEST_CASE("resample: a sine of 1 kHz from 44.1 to 48 kHz and back is that sine within -90 dB", "[apps]") {
  const auto up = app::resample(sine(1000, 44.1_kHz, 22050), 48_kHz);
  REQUIRE(up.sample_rate == 48_kHz);
  REQUIRE(up.frames() == 24000);
  CHECK(db(largest_difference(up, sine(1000, 48_kHz, 24000))) < -90);
  const auto down = app::resample(sine(1000, 48_kHz, 24000), 44.1_kHz);
  REQUIRE(down.frames() == 22050);
  CHECK(db(largest_difference(down, sine(1000, 44.1_kHz, 22050))) < -90);
}

TEST_CASE("resample: what lies above the new Nyquist frequency is gone by 90 dB", "[apps]") {
  const auto frequency = GENERATE(22.1e3, 23.1e3, 26e3, 30e3, 47e3);
  CAPTURE(frequency);
  const auto down = app::resample(sine(frequency, 96_kHz, 48000), 44.1_kHz);
  const Samples silence{44.1_kHz, {std::vector<double>(static_cast<std::size_t>(down.frames()))}};
  CHECK(db(largest_difference(down, silence)) < -90);
}

TEST_CASE("resample: images above the old Nyquist frequency stay below -90 dB", "[apps]") {
  // The image of 15 kHz would stand at 29.1 kHz, inside the new band.
  const auto up = app::resample(sine(15e3, 44.1_kHz, 22050), 96_kHz);
  CHECK(db(largest_difference(up, sine(15e3, 96_kHz, 48000))) < -90);
}

TEST_CASE("resample: flat within 0.01 dB as far as promised", "[apps]") {
  const auto share = GENERATE(0.05, 0.5, 0.8, 0.9);
  CAPTURE(share);
  const auto [from, to] = GENERATE(table<Hertz, Hertz>({{44.1_kHz, 48_kHz}, {96_kHz, 44.1_kHz}}));
  const double frequency = share * std::min(from, to).value / 2;
  const auto out = app::resample(sine(frequency, from, 24000), to);
  // Of a gain g the error against the sine itself is |g - 1|; 0.01 dB is 1.15e-3.
  CHECK(largest_difference(out, sine(frequency, to, out.frames())) < 1.15e-3);
}

TEST_CASE("resample: the gain of a constant is 1 within 1e-4", "[apps]") {
  const auto to = GENERATE(44.1_kHz, 44.101_kHz, 88.2_kHz, 96_kHz, 8_kHz);
  const Samples ones{48_kHz, {std::vector<double>(24000, 1.0)}};
  const auto out = app::resample(ones, to);
  CHECK(largest_difference(out, {to, {std::vector<double>(static_cast<std::size_t>(out.frames()), 1.0)}}) <
        1e-4);
}

TEST_CASE("resample: the same rate gives the same bits, and channels do not mix", "[apps]") {
  auto samples = sine(1000, 48_kHz, 1000);
  samples.channels.emplace_back(1000, 0.0);
  CHECK((app::resample(samples, 48_kHz).channels == samples.channels));
  const auto out = app::resample(samples, 32_kHz);
  REQUIRE(out.channels.size() == 2);
  CHECK(out.channels[1] == std::vector<double>(667, 0.0));  // 1000 * 32 / 48 = 666.7
}

TEST_CASE("resample: nothing stays nothing", "[apps]") {
  CHECK(app::resample({48_kHz, {}}, 44.1_kHz).channels.empty());
  CHECK(app::resample({48_kHz, {{}}}, 44.1_kHz).frames() == 0);
}
