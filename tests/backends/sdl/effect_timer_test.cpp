#include "backends/sdl/effect_timer.h"

#include <catch2/catch.hpp>
#include <vector>

using namespace tactus;
using namespace std::chrono_literals;
using Order = EffectTimer::Order;

TEST_CASE("effect timer: an effect is started, changed at most every 2 ms, and stopped") {
  EffectTimer timer;
  EffectTimer::Clock::time_point now{1h};
  CHECK(timer.next(0.0, now) == Order::None);
  CHECK(timer.next(0.5, now) == Order::Start);
  CHECK(timer.next(0.5, now += 1ms) == Order::None);  // it did not change
  CHECK(timer.next(0.6, now) == Order::None);         // too early
  CHECK(timer.next(0.6, now += 1ms) == Order::Change);
  CHECK(timer.next(0.6, now += 10ms) == Order::None);
  CHECK(timer.next(-0.6, now) == Order::Change);
  CHECK(timer.next(0.0, now += 1ms) == Order::Stop);  // never too early
  CHECK(timer.next(0.0, now += 1ms) == Order::None);
}

TEST_CASE("effect timer: an effect that stays is started again long before it ends in the device") {
  EffectTimer timer;
  EffectTimer::Clock::time_point now{1h};
  std::vector<EffectTimer::Clock::time_point> started;
  for (int ms = 0; ms < 2000; ++ms, now += 1ms)
    if (const auto order = timer.next(0.5, now); order == Order::Start || order == Order::Restart)
      started.push_back(now);
  REQUIRE(started.size() == 10);
  for (std::size_t i = 1; i < started.size(); ++i)
    CHECK(started[i] - started[i - 1] <= EffectTimer::kLength / 2);
}
