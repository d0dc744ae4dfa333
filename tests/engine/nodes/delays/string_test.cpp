#include <catch2/catch.hpp>

#include "engine/core/units.h"
#include "engine/dsp/pitch/pitch_detector.h"
#include "engine/dsp/strings/string_loop.h"
#include "tests/support/measured_response.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kRate = 48000;

StringDesign designed(double pitch, double gain, double loss, LossFilter filter = LossFilter::OneZero) {
  return {{.pitch_hz = pitch, .gain = gain, .loss = loss}, filter, Hertz{kRate}};
}

/// Where the phase once around the loop is a whole turn, near `pitch`: the root of the imaginary part of 1 /
/// H.
double sounding_pitch(NodeRunner& string, double pitch, const std::vector<double>& at) {
  const auto imaginary = [&](double hertz) { return (1.0 / stated_response(string, hertz, at)).imag(); };
  double low = pitch * 0.99, high = pitch * 1.01;
  REQUIRE(imaginary(low) * imaginary(high) < 0);
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (imaginary(low) * imaginary(middle) <= 0 ? high : low) = middle;
  }
  return low;
}

/// The root of 1 = loop(z^-1) next to `pitch`, by Newton's method with a difference for the slope.
double decaying_pitch(const StringDesign& design, double pitch) {
  auto delay = std::polar(1.0, -2 * kPi * pitch / kRate);
  for (int i = 0; i < 30; ++i) {
    const auto step = 1e-7 * delay;
    const auto slope = (design.loop(delay + step) - design.loop(delay - step)) / (2.0 * step);
    delay -= (design.loop(delay) - 1.0) / slope;
  }
  REQUIRE(std::abs(design.loop(delay) - 1.0) < 1e-9);
  return -std::arg(delay) * kRate / (2 * kPi);
}

/// Pitch of a decaying tone near `pitch`: how far its phase turns from one Hann window to a later one.
double measured_pitch(const Samples& y, double pitch, std::size_t first, std::size_t apart,
                      std::size_t window) {
  const auto phasor = [&](std::size_t from) {
    std::complex<double> sum = 0;
    for (std::size_t n = 0; n < window; ++n) {
      const double hann = 1 - std::cos(2 * kPi * static_cast<double>(n) / static_cast<double>(window));
      sum += hann * y[from + n] * std::polar(1.0, -2 * kPi * pitch / kRate * static_cast<double>(from + n));
    }
    return sum;
  };
  const double turned = std::arg(phasor(first + apart) / phasor(first));
  return pitch + turned * kRate / (2 * kPi * static_cast<double>(apart));
}

}  // namespace

TEST_CASE("string: in tune within 0.1 cent from 40 Hz to 4 kHz, by its characteristic equation", "[nodes]") {
  const double gain = GENERATE(0.9, 0.99, 0.999);
  const auto [filter, loss] = GENERATE(table<std::string, double>(
      {{"one_zero", 0.5}, {"one_zero", 0.0}, {"one_zero", 1.0}, {"one_pole", 0.3}, {"one_pole", 0.7}}));
  double worst = 0;
  for (double pitch = 40; pitch <= 4000; pitch *= 1.0293) {
    const std::vector<double> at{0, pitch, gain, loss};
    NodeRunner string{test::node_type("string"), {{"in", 0.0}, {"pitch", pitch}}, {{"loss_filter", filter}}};
    worst = std::max(worst, std::abs(cents(sounding_pitch(string, pitch, at), pitch)));
  }
  INFO(filter << " " << loss << " gain " << gain);
  CHECK(worst < 0.001);
}

TEST_CASE("string: a plucked string sounds at the root of its characteristic equation, at its pitch",
          "[nodes]") {
  const auto [pitch, gain] = GENERATE(table<double, double>(
      {{40, 0.9}, {220, 0.99}, {440, 0.999}, {997, 0.99}, {2000, 0.999}, {4000, 0.999}, {4000, 0.9}}));
  const auto [filter, loss] =
      GENERATE(table<std::string, double>({{"one_zero", 0.1}, {"one_zero", 0.5}, {"one_pole", 0.3}}));
  NodeRunner string{test::node_type("string"),
                    {{"in", impulse(24000)}, {"pitch", pitch}, {"gain", gain}, {"loss", loss}},
                    {{"loss_filter", filter}}};
  const auto y = string.run(even_cutting(24000, 64))[0];
  // Two windows of twelve periods, six apart: other partials leave less than 1e-4 of a Hann window.
  const auto periods = [hertz = pitch](double count) {
    return static_cast<std::size_t>(std::lround(count * kRate / hertz));
  };
  const double measured = measured_pitch(y, pitch, periods(2), periods(6), periods(12));
  const double root = decaying_pitch(
      designed(pitch, gain, loss, filter == "one_zero" ? LossFilter::OneZero : LossFilter::OnePole), pitch);
  INFO(filter << " " << loss << " " << pitch << " gain " << gain << ": root at " << cents(root, pitch)
              << " cents");
  CHECK(cents(measured, root) == Approx(0).margin(0.05));
  const bool dies_at_once = pitch == 4000 && (gain == 0.9 || filter == "one_pole");  // T60 below 30 ms
  CHECK(cents(root, pitch) == Approx(0).margin(dies_at_once ? 1.2 : 0.1));
}

TEST_CASE("string: partials die as g |H_LP| once a period says", "[nodes]") {
  const double gain = GENERATE(0.9, 0.99, 0.999);
  constexpr double kPitch = 480;  // a period of 100 frames
  NodeRunner string{test::node_type("string"),
                    {{"in", impulse(48000)}, {"pitch", kPitch}, {"gain", gain}, {"loss", 0.5}}};
  const auto y = string.run(even_cutting(48000, 64))[0];
  const auto level = [&](std::size_t from) {
    std::complex<double> sum = 0;
    for (std::size_t n = from; n < from + 1200; ++n)
      sum += (1 - std::cos(2 * kPi * static_cast<double>(n - from) / 1200)) * y[n] *
             std::polar(1.0, -2 * kPi * kPitch / kRate * static_cast<double>(n));
    return std::abs(sum);
  };
  const double w = 2 * kPi * kPitch / kRate;
  const auto loss_filter = 0.75 + 0.25 * std::polar(1.0, -w);
  const double loop_frames = 100 + std::arg(loss_filter) / w;
  const double expected_t60 = 3 * loop_frames / kRate / -std::log10(gain * std::abs(loss_filter));
  const double decades = std::log10(level(1000) / level(3000));
  // The group delay of H_LP and what the interpolator takes away change it by less than 0.5 %.
  CHECK(3 * (2000 / kRate) / decades == Approx(expected_t60).epsilon(0.005));
}

TEST_CASE("string: loops of whole frames are exact", "[nodes]") {
  // Without loss, 480 Hz at 48 kHz is a delay of 100 frames: impulses of 1, g, g^2 ...
  NodeRunner string{test::node_type("string"),
                    {{"in", impulse(1000)}, {"pitch", 480.0}, {"gain", 0.5}, {"loss", 0.0}}};
  const auto y = string.run(random_cutting(1000, 1))[0];
  for (std::size_t n = 0; n < y.size(); ++n)
    CHECK(y[n] == Approx(n % 100 == 0 ? std::pow(0.5, static_cast<double>(n / 100)) : 0.0).margin(1e-14));
}

TEST_CASE("string: the loop stays below 1 at every frequency, pitch and loss", "[nodes]") {
  const auto filter = GENERATE(LossFilter::OneZero, LossFilter::OnePole);
  for (double pitch = 5; pitch < 30000; pitch *= 1.07)
    for (const double loss : {0.0, 0.5, 1.0})
      for (double radians = 0; radians < kPi; radians += 0.05)
        REQUIRE(std::abs(designed(pitch, 1, loss, filter).loop(std::polar(1.0, -radians))) < 1);
}

TEST_CASE("string: the stated response is the measured one", "[nodes]") {
  const auto filter = GENERATE(as<std::string>(), "one_zero", "one_pole");
  const double pitch = GENERATE(55.0, 1234.5, 9000.0);
  NodeRunner string{test::node_type("string"),
                    {{"in", impulse(96000)}, {"pitch", pitch}, {"gain", 0.5}, {"loss", 0.4}},
                    {{"loss_filter", filter}}};
  const auto y = string.run(even_cutting(96000, 64))[0];
  for (const double hertz : {0.0, 55.0, 1000.0, 1234.5, 9000.0, 20000.0}) {
    const auto stated = stated_response(string, hertz, {0, pitch, 0.5, 0.4});
    CHECK(std::abs(spectrum_at(y, hertz) - stated) < 1e-9 * std::abs(stated));  // 0.5^110 after 2 s at 55 Hz
  }
}

TEST_CASE("string: any cutting into blocks gives the same bits", "[nodes]") {
  const auto filter = GENERATE(as<std::string>(), "one_zero", "one_pole");
  const InputValue pitch = GENERATE(InputValue{41.0}, InputValue{440.0}, InputValue{4100.0},
                                    InputValue{15000.0}, InputValue{noise(2000, 3, 5, 16000)});
  NodeRunner string{test::node_type("string"),
                    {{"in", noise(2000, 1)}, {"pitch", pitch}, {"loss", noise(2000, 4, -0.5, 1.5)}},
                    {{"loss_filter", filter}}};
  CHECK(string.cutting_matters(2000) == "");
  CHECK(string.cutting_matters(2000, 3, 1000005) == "");
  NodeRunner steady{
      test::node_type("string"), {{"in", noise(2000, 1)}, {"pitch", 300.0}}, {{"loss_filter", filter}}};
  CHECK(steady.cutting_matters(2000) == "");
}

TEST_CASE("string: any parameter is made valid", "[nodes]") {
  const double wild = GENERATE(-1.0, 0.0, 1e9, std::numeric_limits<double>::quiet_NaN());
  const auto port = GENERATE(as<std::string>(), "pitch", "gain", "loss");
  const auto filter = GENERATE(as<std::string>(), "one_zero", "one_pole");
  std::map<std::string, InputValue> inputs{{"in", noise(5000, 1)}, {"pitch", 440.0}};
  inputs[port] = wild;
  NodeRunner string{test::node_type("string"), inputs, {{"loss_filter", filter}}};
  const auto out = string.run(even_cutting(5000, 64));
  for (const double y : out[0]) REQUIRE(std::abs(y) < 1e4);
}
