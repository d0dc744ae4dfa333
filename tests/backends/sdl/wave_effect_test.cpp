#include "backends/sdl/wave_effect.h"

#include <catch2/catch.hpp>
#include <vector>

using namespace tactus;
using namespace std::chrono_literals;

namespace {

constexpr std::array<double, 5> kDefaults{};

/// What is sent for a wave from `from` on, of one decision per millisecond.
struct Sent {
  std::vector<std::pair<int, WaveEffect::Step>> steps;  ///< with the millisecond

  void play(WaveEffect& effect, const Wave& wave, int from_ms, int to_ms, bool allowed = true) {
    for (int ms = from_ms; ms < to_ms; ++ms) {
      const auto step = effect.next(wave, WaveEffect::Clock::time_point{1h} + ms * 1ms, allowed);
      if (step.uploads || step.runs || step.stops) steps.emplace_back(ms, step);
    }
  }
};

}  // namespace

TEST_CASE("wave effect: levels are fields of the device, and 0 is their default") {
  CHECK(wave_of(0.0, kDefaults) == Wave{});
  CHECK(wave_of(-0.5, kDefaults).magnitude == 16384);  // 0.5 * 32767, rounded
  const auto wave = wave_of(1.0, std::array{0.025, -0.25, 0.25, 0.1, 0.15});
  CHECK(wave == Wave{.magnitude = 32767,
                     .offset = -8192,
                     .phase = 9000,
                     .period_ms = 25,
                     .attack_ms = 100,
                     .fade_ms = 150});
  CHECK(wave_of(1.0, std::array{0.0004, 0.0, -0.25, 0.0, 0.0}) == Wave{.magnitude = 32767, .phase = 27000});
  const auto least = wave_of(9.0, std::array{-1.0, -9.0, -1.0, -1.0, -1.0});
  CHECK(least == Wave{.magnitude = 32767, .offset = -32767, .phase = 0, .period_ms = 1});
  const auto most = wave_of(9.0, std::array{1.0, 9.0, 1.0, 1.0, 1.0});
  CHECK(most == Wave{.magnitude = 32767,
                     .offset = 32767,
                     .phase = 0,
                     .period_ms = 200,
                     .attack_ms = 200,
                     .fade_ms = 200});
}

TEST_CASE("wave effect: it is started again after a whole number of periods, before it ends by itself") {
  const int period = GENERATE(1, 7, 10, 30, 150, 199, 200);
  CAPTURE(period);
  WaveEffect effect;
  Sent sent;
  const auto wave = wave_of(0.5, std::array{period / 1000.0, 0.0, 0.0, 0.05, 0.0});
  sent.play(effect, wave, 0, 2000);
  REQUIRE(sent.steps.size() >= 5);
  CHECK(sent.steps[0].second.wave.attack_ms == 50);
  for (std::size_t s = 1; s < sent.steps.size(); ++s) {
    const auto& [ms, step] = sent.steps[s];
    const int after = ms - sent.steps[s - 1].first;
    CHECK(step.runs);
    CHECK(after % period == 0);
    CHECK(after >= EffectTimer::kRestart.count());
    CHECK(after <= EffectTimer::kLength.count() - 100);
    CHECK(step.wave.attack_ms == 0);
    CHECK(step.wave.attack_level == 32767);  // not all of its envelope is 0
    CHECK(step.uploads == (s == 1));         // without the attack
  }
}

TEST_CASE("wave effect: what changes is sent once, when a report is allowed, in as few reports as it takes") {
  WaveEffect effect;
  Sent sent;
  std::array settings{0.02, 0.0, 0.0, 0.1, 0.1};
  sent.play(effect, wave_of(0.5, settings), 0, 10);
  CHECK(sent.steps.size() == 1);
  settings[0] = 0.04;
  settings[1] = 0.1;
  sent.play(effect, wave_of(0.6, settings), 10, 15, false);
  CHECK(sent.steps.size() == 1);
  sent.play(effect, wave_of(0.6, settings), 15, 20);
  REQUIRE(sent.steps.size() == 2);
  const auto& step = sent.steps[1].second;
  CHECK(step.uploads);
  CHECK_FALSE(step.runs);
  CHECK(step.reports == 1);
  CHECK(step.wave.period_ms == 40);
  CHECK(step.wave.offset == 3277);
  CHECK(step.wave.attack_ms == 100);  // it goes on
  CHECK(step.wave.fade_ms == 0);      // until the effect is stopped
  settings[4] = 0.2;
  sent.play(effect, wave_of(0.6, settings), 20, 25);
  CHECK(sent.steps.size() == 2);
}

TEST_CASE("wave effect: at strength 0 it fades from where its wave is, or is stopped") {
  WaveEffect effect;
  Sent sent;
  sent.play(effect, wave_of(0.5, std::array{0.04, 0.0, 0.25, 0.0, 0.15}), 0, 250);
  CHECK(sent.steps.size() == 2);  // and again after 200 ms
  sent.steps.clear();
  sent.play(effect, wave_of(0.0, std::array{0.04, 0.0, 0.25, 0.0, 0.15}), 250, 500, false);
  REQUIRE(sent.steps.size() == 1);
  const auto fade = sent.steps[0].second;
  CHECK(fade.uploads);
  CHECK(fade.runs);
  // A quarter of a turn, and 50 ms of 40 ms.
  CHECK(fade.wave ==
        Wave{.magnitude = 16384, .phase = 18000, .period_ms = 40, .fade_ms = 150, .length_ms = 150});
  CHECK(fade.reports == 3);
  sent.steps.clear();
  sent.play(effect, wave_of(0.5, kDefaults), 500, 510);
  REQUIRE(sent.steps.size() == 1);
  CHECK(sent.steps[0].second.wave == Wave{.magnitude = 16384, .attack_level = 32767});
  sent.play(effect, wave_of(0.0, kDefaults), 510, 900);
  REQUIRE(sent.steps.size() == 2);
  CHECK(sent.steps[1].second.stops);
  CHECK_FALSE(sent.steps[1].second.runs);
}

TEST_CASE("wave effect: what a device did not take is sent as a whole when it would be started again") {
  WaveEffect effect;
  Sent sent;
  const auto wave = wave_of(0.5, std::array{0.02, 0.0, 0.0, 0.0, 0.1});
  sent.play(effect, wave, 0, 1);
  effect.forget();
  sent.play(effect, wave, 1, 300);
  REQUIRE(sent.steps.size() == 2);
  CHECK(sent.steps[1].first == 200);
  CHECK(sent.steps[1].second.uploads);
  effect.forget();
  sent.play(effect, wave_of(0.0, std::array{0.02, 0.0, 0.0, 0.0, 0.1}), 300, 400);
  REQUIRE(sent.steps.size() == 3);
  CHECK_FALSE(sent.steps[2].second.runs);  // nothing that could fade
}
