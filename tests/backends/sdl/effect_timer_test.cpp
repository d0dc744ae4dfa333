#include "backends/sdl/effect_timer.h"

#include <catch2/catch.hpp>
#include <vector>

using namespace tactus;
using namespace std::chrono_literals;
using Order = EffectTimer::Order;

TEST_CASE(
    "effect timer: an effect is started and changed when a report is allowed, and stopped at any time") {
  EffectTimer timer;
  const EffectTimer::Clock::time_point now{1h};
  CHECK(timer.next(0.0, now, true) == Order::None);
  CHECK(timer.next(0.5, now, false) == Order::None);
  CHECK(timer.next(0.5, now, true) == Order::Start);
  CHECK(timer.next(0.5, now, true) == Order::None);  // it did not change
  CHECK(timer.next(0.6, now, false) == Order::None);
  CHECK(timer.next(0.6, now, true) == Order::Change);
  CHECK(timer.next(0.6, now, true) == Order::None);
  CHECK(timer.next(-0.6, now, true) == Order::Change);
  CHECK(timer.next(0.0, now, false) == Order::Stop);
  CHECK(timer.next(0.0, now, true) == Order::None);
}

TEST_CASE("report budget: whatever is to be sent, one report in 2 ms is") {
  ReportBudget budget;
  ReportBudget::Clock::time_point now{1h};
  int sent = 0;
  for (int ms = 0; ms < 1000; ++ms, now += 1ms)
    if (const int reports = 1 + ms % 5; budget.allows(now)) {
      budget.spend(reports, now);
      sent += reports;
    }
  CHECK(sent >= 500);
  CHECK(sent <= 500 + 5);  // the last ones
  budget.spend(9, now);    // stops, which do not wait
  CHECK_FALSE(budget.allows(now + 17ms));
  now += 1h;  // a rest saves nothing up
  CHECK(budget.allows(now));
  budget.spend(1, now);
  CHECK_FALSE(budget.allows(now + 1ms));
  CHECK(budget.allows(now + 2ms));
}

TEST_CASE("effect timer: an effect that stays is started again long before it ends in the device") {
  EffectTimer timer;
  EffectTimer::Clock::time_point now{1h};
  std::vector<EffectTimer::Clock::time_point> started;
  for (int ms = 0; ms < 2000; ++ms, now += 1ms)
    if (const auto order = timer.next(0.5, now, true); order == Order::Start || order == Order::Restart)
      started.push_back(now);
  REQUIRE(started.size() == 10);
  for (std::size_t i = 1; i < started.size(); ++i)
    CHECK(started[i] - started[i - 1] <= EffectTimer::kLength / 2);
}
