#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "engine/dsp/curves/curve_kernel.h"
#include "engine/dsp/envelopes/envelope_kernel.h"
#include "engine/dsp/generators/counter_noise.h"
#include "engine/nodes/envelopes/pulse_kernel.h"
#include "engine/nodes/logic/threshold_skip.h"

using namespace tactus;

TEST_CASE("rise: fires in one frame, at 0.5, and again only after a fall", "[dsp]") {
  tactus_rise rise{}, other{};
  const std::pair<double, bool> frames[] = {{0.49, false}, {0.5, true},  {1, false},
                                            {0.5, false},  {0.4, false}, {1, true}};
  for (const auto& [value, fires] : frames) CHECK(tactus_rise_step(&rise, value) == fires);
  CHECK(tactus_rise_step(&other, 1.0));
}

TEST_CASE("time_constant: keeps 1/e over its time, zero keeps nothing", "[dsp]") {
  tactus_time_constant time{};
  CHECK(std::pow(tactus_time_constant_keep(&time, 0.010, 48000), 480) ==
        Approx(std::exp(-1.0)).epsilon(1e-13));
  CHECK(tactus_time_constant_keep(&time, 0, 48000) == 0);
  CHECK(tactus_time_constant_keep(&time, -1, 48000) == 0);
}

TEST_CASE("envelope_follower: rises and falls as the exponentials of its time constants", "[dsp]") {
  const auto [attack_s, release_s] = GENERATE(std::pair{0.0005, 0.020}, std::pair{0.020, 0.0005});
  const double attack = tactus_keep(attack_s, 48000), release = tactus_keep(release_s, 48000);
  tactus_follower follower{};
  for (int n = 0; n < 100; ++n) tactus_follower_step(&follower, -2.0, attack, release);
  const double risen = 2 * (1 - std::exp(-100 / (48000 * attack_s)));
  CHECK(follower.envelope == Approx(risen).epsilon(1e-12));
  for (int n = 0; n < 100; ++n) tactus_follower_step(&follower, 0.0, attack, release);
  CHECK(follower.envelope == Approx(risen * std::exp(-100 / (48000 * release_s))).epsilon(1e-12));
}

TEST_CASE("envelope_follower: without a branch as with one", "[dsp]") {
  const auto [attack_keep, release_keep] =
      GENERATE(std::pair{0.9, 0.999}, std::pair{0.999, 0.9}, std::pair{0.0, 0.5});
  const CounterNoise noise(1, 0);
  tactus_follower follower{};
  double reference = 0, worst = 0;
  for (int n = 0; n < 10'000; ++n) {
    const double in = noise.uniform(n);
    tactus_follower_step(&follower, in, attack_keep, release_keep);
    reference += (1 - (std::abs(in) > reference ? attack_keep : release_keep)) * (std::abs(in) - reference);
    worst = std::max(worst, std::abs(follower.envelope - reference));
  }
  CHECK(worst < 1e-13);  // a few roundings, forgotten at the slower rate
}

TEST_CASE("pulse: e^(-t / tau) to the rounding of one product a frame", "[dsp]") {
  const double keep = tactus_keep(0.1, 48000);
  tactus_pulse pulse{.value = 0.5, .age = 0};
  double value = 0;
  for (int n = 0; n <= 48000; ++n) value = tactus_pulse_step(&pulse, keep, 0);
  CHECK(value == Approx(0.5 * std::exp(-10.0)).epsilon(48000 * 2.3e-16));
}

TEST_CASE("pulse: ends in the frame of its length", "[dsp]") {
  tactus_pulse pulse{.value = 1, .age = 0};
  for (int n = 0; n < 10; ++n) CHECK(tactus_pulse_step(&pulse, 1.0, 9.6) == 1);
  CHECK(tactus_pulse_step(&pulse, 1.0, 9.6) == 0);
}

TEST_CASE("adsr: linear attack, exponential decay and release", "[dsp]") {
  tactus_adsr adsr{};
  const auto step = [&](double gate) { return tactus_adsr_move(&adsr, gate, 1.0 / 64, 0.99, 0.25, 0.98); };
  for (int n = 1; n <= 64; ++n) CHECK(step(1) == n / 64.0);
  for (int n = 1; n <= 100; ++n) step(1);
  const double decayed = 0.25 + 0.75 * std::pow(0.99, 100);
  CHECK(adsr.value == Approx(decayed).epsilon(1e-13));
  for (int n = 1; n <= 50; ++n) step(0);
  const double released = decayed * std::pow(0.98, 50);
  CHECK(adsr.value == Approx(released).epsilon(1e-13));
  CHECK(step(1) == Approx(released + 1.0 / 64).epsilon(1e-13));  // from where it is
}

TEST_CASE("threshold: releases only below its hysteresis", "[dsp]") {
  tactus_threshold state{};
  const auto step = [&](double in) { return tactus_threshold_step(&state, in, 1, 0.2, 0) != 0; };
  CHECK_FALSE(step(0.99));
  CHECK(step(1.0));
  CHECK_FALSE(step(0.85));
  CHECK(state.high);
  CHECK_FALSE(step(0.79));
  CHECK_FALSE(state.high);
  CHECK(step(1.1));
}

TEST_CASE("threshold: waits, and fires late where it was reached in the meantime", "[dsp]") {
  tactus_threshold state{};
  const auto step = [&](double in) { return tactus_threshold_step(&state, in, 1, 0.5, 3) != 0; };
  CHECK(step(1));
  CHECK_FALSE(step(0));
  CHECK_FALSE(step(1));
  CHECK(step(0.9 + 0.1));
  CHECK_FALSE(step(2));  // not below the hysteresis since
}

TEST_CASE("threshold: frames that change nothing may be left out", "[dsp]") {
  std::mt19937 bits(5);
  for (int run = 0; run < 2000; ++run) {
    tactus_threshold plain{}, quick{};
    std::array<double, 12> in;
    const double spread = 0.2 + (run % 10) * 0.1;
    int skipped = 0;
    for (int piece = 0; piece < 20; ++piece) {
      for (auto& x : in) x = 0.6 + spread * (static_cast<double>(bits()) / 2147483648.0 - 1);
      const bool left_out = changes_nothing(quick, in.data(), 12, 1.0, 0.5);
      skipped += left_out;
      if (left_out) tactus_threshold_pass(&quick, 12);
      for (const double x : in) {
        const bool fired = tactus_threshold_step(&plain, x, 1.0, 0.5, 30) != 0;
        CHECK_FALSE((left_out && fired));
        if (!left_out) tactus_threshold_step(&quick, x, 1.0, 0.5, 30);
      }
      CHECK(plain.high == quick.high);
      CHECK(plain.fired == quick.fired);
      CHECK(plain.wait == quick.wait);
    }
    if (run % 10 == 0) CHECK(skipped > 0);
  }
}

TEST_CASE("quantise: multiples of the step, and no rounding where the step vanishes", "[dsp]") {
  CHECK(tactus_quantise_nearest(0.74, 0.5) == 0.5);
  CHECK(tactus_quantise_nearest(-0.76, 0.5) == -1.0);
  CHECK(tactus_quantise_nearest(0.75, 0.5) == 1.0);  // 1.5 steps: to the even multiple
  CHECK(tactus_quantise_floor(-0.01, 0.5) == -0.5);
  CHECK(tactus_quantise_floor(0.99, 0.5) == 0.5);
  for (const double step : {0.0, -1.0, 1e-320}) CHECK(tactus_quantise_nearest(1e10, step) == 1e10);
}
