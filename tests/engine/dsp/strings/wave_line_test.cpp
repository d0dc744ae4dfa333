#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/units.h"
#include "engine/dsp/strings/string_loop.h"
#include "tests/support/measured_response.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kRate = 48000;

WaveLine line_of(LossFilter filter, FarEnd end, double pitch) {
  return {filter, end, Hertz{kRate}, {pitch, pitch}};
}

std::complex<double> at(const WaveLine& line, const StringParameters& parameters, double hertz) {
  return line.response(parameters, std::polar(1.0, -2 * kPi * hertz / kRate));
}

}  // namespace

TEST_CASE("wave_line: it never gives back more than came in, at any frequency", "[dsp]") {
  const auto filter = GENERATE(LossFilter::OneZero, LossFilter::OnePole);
  const double loss = GENERATE(0.0, 0.1, 0.5, 0.99);
  double most = 0;
  for (double pitch = 20; pitch < 9600; pitch *= 1.0371) {
    const auto line = line_of(filter, FarEnd::Fixed, pitch);
    for (double f = 1; f < 24000; f += 97.3) most = std::max(most, std::abs(at(line, {pitch, 1.0, loss}, f)));
  }
  CHECK(most <= 1 + 1e-12);
  CHECK(most > 0.99);
}

TEST_CASE("wave_line: with the frames of a port, its pitch comes back in phase from a fixed end", "[dsp]") {
  const auto filter = GENERATE(LossFilter::OneZero, LossFilter::OnePole);
  const double loss = GENERATE(0.0, 0.5);
  for (double pitch = 40; pitch < 4000; pitch *= 1.07) {
    const auto frame = std::polar(1.0, -2 * kPi * pitch / kRate * TACTUS_WAVEGUIDE_PORT);
    const StringParameters parameters{pitch, 0.99, loss};
    const auto fixed = frame * at(line_of(filter, FarEnd::Fixed, pitch), parameters, pitch);
    // A tenth of a cent is 6e-5 of a period.
    CHECK(std::abs(std::arg(fixed)) < 2 * kPi * 6e-5);
    CHECK(std::abs(at(line_of(filter, FarEnd::Free, pitch), parameters, pitch) * frame + fixed) < 1e-12);
  }
}

TEST_CASE("wave_line: what it states is what it does, in blocks of any length", "[dsp]") {
  const auto filter = GENERATE(LossFilter::OneZero, LossFilter::OnePole);
  const StringParameters parameters{311.7, 0.98, 0.4};
  WaveLine line(filter, FarEnd::Free, Hertz{kRate}, {100, 400});
  line.tune(parameters);
  const auto in = impulse(4000);
  Samples out(in.size());
  int from = 0;
  for (const int frames : random_cutting(4000, 8)) {
    line.write(in.data() + from, frames);
    line.read(out.data() + from, frames, frames, from % kGroup);
    from += frames;
  }
  for (const double f : {10.0, 500.0, 3000.0, 15000.0})
    CHECK(std::abs(spectrum_at(out, f) - at(line, parameters, f)) < 1e-12);
  CHECK(std::count(out.begin(), out.begin() + line.least_delay(), 0.0) == line.least_delay());
  CHECK(line.least_delay() > 80);  // 120 around at 400 Hz, less what the darkest loss takes
}
