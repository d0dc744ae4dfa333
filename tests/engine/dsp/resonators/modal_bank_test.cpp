#include "engine/dsp/resonators/modal_bank.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/graphs/node_runner.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kRate = 48000;

struct Mode {
  double frequency_hz, decay_s, gain;
};

tactus_mode designed(const Mode& mode) {
  return tactus_mode_design(mode.frequency_hz, mode.decay_s, mode.gain, kRate);
}

/// Even steps of pitch from 60 Hz to 12 kHz, high modes shorter, signs in turn.
std::vector<Mode> modes_of(int count) {
  std::vector<Mode> modes;
  for (int k = 0; k < count; ++k) {
    const double f = 60 * std::pow(200.0, k / std::max(1.0, count - 1.0));
    modes.push_back({f, 1.5 * std::sqrt(60 / f), (k % 2 == 0 ? 1.0 : -1.0) / (k + 1)});
  }
  return modes;
}

ModalBank bank_of(const std::vector<Mode>& modes) {
  ModalBank bank(static_cast<int>(modes.size()));
  for (std::size_t k = 0; k < modes.size(); ++k) bank.set(static_cast<int>(k), designed(modes[k]));
  return bank;
}

double damped_sines(const std::vector<Mode>& modes, double t) {
  double sum = 0;
  for (const auto& mode : modes)
    sum +=
        mode.gain * std::pow(1e-3, t / mode.decay_s) * std::sin(2 * std::numbers::pi * mode.frequency_hz * t);
  return sum;
}

}  // namespace

// The bank's radius is off by a rounding, 1e-16 a frame: 1e-12 of the mode at the time constant of 10000
// frames. The analytic sine itself is off by 2 pi f t 1e-16, 1e-11 where the highest modes still ring.
TEST_CASE("modal_bank: an impulse rings as the sum of damped sines", "[dsp]") {
  const int count = GENERATE(1, 7, 8, 23, 40, 131);
  const auto modes = modes_of(count);
  auto bank = bank_of(modes);
  // The frame before the first output.
  auto in = impulse(48000);
  Samples out(in.size());
  bank.run(in.data(), out.data(), static_cast<int>(in.size()));
  double worst = 0;
  for (std::size_t n = 0; n < out.size(); ++n)
    worst = std::max(worst, std::abs(out[n] - damped_sines(modes, static_cast<double>(n + 1) / kRate)));
  INFO(count << " modes");
  CHECK(worst < 1e-11);
}

TEST_CASE("modal_bank: the cut into blocks changes no bit, however many modes", "[dsp]") {
  const int count = GENERATE(1, 9, 24, 40, 64, 100);
  const auto in = noise(2000, 3);
  const auto play = [&](const std::vector<int>& lengths) {
    auto bank = bank_of(modes_of(count));
    Samples out(in.size());
    int from = 0;
    for (const int length : lengths) {
      bank.run(in.data() + from, out.data() + from, length);
      from += length;
    }
    return out;
  };
  const auto whole = play({2000});
  CHECK(first_difference({whole}, {play(even_cutting(2000, 1))}) == "");
  CHECK(first_difference({whole}, {play(random_cutting(2000, 5))}) == "");
}

TEST_CASE("modal_bank: at half the sample rate and above a mode is silent", "[dsp]") {
  const double frequency = GENERATE(24000.0, 30000.0, 1e9, 0.0, -100.0);
  auto bank = bank_of({{frequency, 1, 1}});
  const auto in = noise(100, 4);
  Samples out(in.size());
  bank.run(in.data(), out.data(), 100);
  CHECK(out == Samples(100, 0.0));
}

TEST_CASE("modal_bank: it decays at any frequency, whatever decay is asked for", "[dsp]") {
  for (const double decay : {-1.0, 0.0, 1e-9, 1.0, 1e30})
    for (double f = 1; f < 24000; f *= 1.7) {
      const auto design = designed({f, decay, 1});
      // The triangle of stable two-pole resonators: |a1| < 1 - a2, a2 > -1.
      const double a1 = 1 + design.turn, a2 = -design.turn - design.pull;
      CHECK(a2 > -1);
      CHECK(design.pull > 0);
      CHECK(a1 > a2 - 1);
    }
}

TEST_CASE("modal_bank: another bank goes on where one was", "[dsp]") {
  const auto modes = modes_of(20);
  auto first = bank_of(modes), second = bank_of(modes);
  auto in = impulse(200);
  Samples ringing(200), taken_over(200);
  first.run(in.data(), ringing.data(), 200);
  for (int mode = 0; mode < 20; ++mode) second.adopt(mode, first, mode);
  in[0] = 0;
  first.run(in.data(), ringing.data(), 200);
  second.run(in.data(), taken_over.data(), 200);
  CHECK(first_difference({ringing}, {taken_over}) == "");
}
