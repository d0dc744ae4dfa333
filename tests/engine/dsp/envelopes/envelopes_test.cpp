#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "engine/dsp/curves/comparator.h"
#include "engine/dsp/curves/quantise.h"
#include "engine/dsp/envelopes/adsr.h"
#include "engine/dsp/envelopes/envelope_follower.h"
#include "engine/dsp/envelopes/pulse.h"
#include "engine/dsp/envelopes/rise.h"
#include "engine/dsp/envelopes/time_constant.h"
#include "engine/dsp/generators/counter_noise.h"

using namespace tactus;

TEST_CASE("rise: fires in one frame, at 0.5, and again only after a fall", "[dsp]") {
  Rise rise;
  const std::pair<double, bool> frames[] = {{0.49, false}, {0.5, true},  {1, false},
                                            {0.5, false},  {0.4, false}, {1, true}};
  for (const auto& [value, fires] : frames) CHECK(rise.step(value) == fires);
  CHECK(Rise{}.step(1.0));
}

TEST_CASE("time_constant: keeps 1/e over its time, zero keeps nothing", "[dsp]") {
  TimeConstant time(48_kHz);
  CHECK(std::pow(time.keep(0.010), 480) == Approx(std::exp(-1.0)).epsilon(1e-13));
  CHECK(time.keep(0) == 0);
  CHECK(time.keep(-1) == 0);
}

TEST_CASE("envelope_follower: rises and falls as the exponentials of its time constants", "[dsp]") {
  TimeConstant attack(48_kHz), release(48_kHz);
  const auto [attack_s, release_s] = GENERATE(std::pair{0.0005, 0.020}, std::pair{0.020, 0.0005});
  EnvelopeFollower follower;
  for (int n = 0; n < 100; ++n) follower.step(-2.0, attack.keep(attack_s), release.keep(release_s));
  const double risen = 2 * (1 - std::exp(-100 / (48000 * attack_s)));
  CHECK(follower.envelope == Approx(risen).epsilon(1e-12));
  for (int n = 0; n < 100; ++n) follower.step(0.0, attack.keep(attack_s), release.keep(release_s));
  CHECK(follower.envelope == Approx(risen * std::exp(-100 / (48000 * release_s))).epsilon(1e-12));
}

TEST_CASE("envelope_follower: without a branch as with one", "[dsp]") {
  const auto [attack_keep, release_keep] =
      GENERATE(std::pair{0.9, 0.999}, std::pair{0.999, 0.9}, std::pair{0.0, 0.5});
  const CounterNoise noise(1, 0);
  EnvelopeFollower follower;
  double reference = 0, worst = 0;
  for (int n = 0; n < 10'000; ++n) {
    const double in = noise.uniform(n);
    follower.step(in, attack_keep, release_keep);
    reference += (1 - (std::abs(in) > reference ? attack_keep : release_keep)) * (std::abs(in) - reference);
    worst = std::max(worst, std::abs(follower.envelope - reference));
  }
  CHECK(worst < 1e-13);  // a few roundings, forgotten at the slower rate
}

TEST_CASE("pulse: e^(-t / tau) to the rounding of one product a frame", "[dsp]") {
  TimeConstant time(48_kHz);
  Pulse pulse;
  pulse.start(0.5);
  double value = 0;
  for (int n = 0; n <= 48000; ++n) value = pulse.step(time.keep(0.1), 0);
  CHECK(value == Approx(0.5 * std::exp(-10.0)).epsilon(48000 * 2.3e-16));
}

TEST_CASE("pulse: ends in the frame of its length", "[dsp]") {
  Pulse pulse;
  pulse.start(1);
  for (int n = 0; n < 10; ++n) CHECK(pulse.step(1.0, 9.6) == 1);
  CHECK(pulse.step(1.0, 9.6) == 0);
}

TEST_CASE("adsr: linear attack, exponential decay and release", "[dsp]") {
  const Adsr::Rates rates = {.rise = 1.0 / 64, .decay_keep = 0.99, .sustain = 0.25, .release_keep = 0.98};
  Adsr adsr;
  for (int n = 1; n <= 64; ++n) CHECK(adsr.step(1, rates) == n / 64.0);
  for (int n = 1; n <= 100; ++n) adsr.step(1, rates);
  const double decayed = 0.25 + 0.75 * std::pow(0.99, 100);
  CHECK(adsr.value == Approx(decayed).epsilon(1e-13));
  for (int n = 1; n <= 50; ++n) adsr.step(0, rates);
  const double released = decayed * std::pow(0.98, 50);
  CHECK(adsr.value == Approx(released).epsilon(1e-13));
  CHECK(adsr.step(1, rates) == Approx(released + 1.0 / 64).epsilon(1e-13));  // from where it is
}

TEST_CASE("comparator: lets go only below its hysteresis", "[dsp]") {
  Comparator comparator;
  CHECK_FALSE(comparator.step(0.99, 1, 0.2));
  CHECK(comparator.step(1.0, 1, 0.2));
  CHECK_FALSE(comparator.step(0.85, 1, 0.2));
  CHECK(comparator.high);
  CHECK_FALSE(comparator.step(0.79, 1, 0.2));
  CHECK_FALSE(comparator.high);
  CHECK(comparator.step(1.1, 1, 0.2));
}

TEST_CASE("comparator: waits, and fires late where it was reached in the meantime", "[dsp]") {
  Comparator comparator;
  CHECK(comparator.step(1, 1, 0.5));
  comparator.wait = 3;
  CHECK_FALSE(comparator.step(0, 1, 0.5));
  CHECK_FALSE(comparator.step(1, 1, 0.5));
  CHECK(comparator.step(0.9 + 0.1, 1, 0.5));
  CHECK_FALSE(comparator.step(2, 1, 0.5));  // not below the hysteresis since
}

TEST_CASE("comparator: frames that change nothing may be left out", "[dsp]") {
  std::mt19937 bits(5);
  for (int run = 0; run < 2000; ++run) {
    Comparator plain, quick;
    std::array<double, 12> in;
    const double spread = 0.2 + (run % 10) * 0.1;
    int skipped = 0;
    for (int piece = 0; piece < 20; ++piece) {
      for (auto& x : in) x = 0.6 + spread * (static_cast<double>(bits()) / 2147483648.0 - 1);
      const bool left_out = quick.indifferent(in.data(), 12, 1.0, 0.5);
      skipped += left_out;
      if (left_out) quick.pass(12);
      for (const double x : in) {
        const bool fired = plain.step(x, 1.0, 0.5);
        if (fired) plain.wait = 30;
        CHECK_FALSE((left_out && fired));
        if (!left_out && quick.step(x, 1.0, 0.5)) quick.wait = 30;
      }
      CHECK(plain.high == quick.high);
      CHECK(plain.armed == quick.armed);
      CHECK(plain.wait == quick.wait);
    }
    if (run % 10 == 0) CHECK(skipped > 0);
  }
}

TEST_CASE("quantise: multiples of the step, and no rounding where the step vanishes", "[dsp]") {
  CHECK(quantise_nearest(0.74, 0.5) == 0.5);
  CHECK(quantise_nearest(-0.76, 0.5) == -1.0);
  CHECK(quantise_nearest(0.75, 0.5) == 1.0);  // 1.5 steps: to the even multiple
  CHECK(quantise_floor(-0.01, 0.5) == -0.5);
  CHECK(quantise_floor(0.99, 0.5) == 0.5);
  for (const double step : {0.0, -1.0, 1e-320}) CHECK(quantise_nearest(1e10, step) == 1e10);
}
