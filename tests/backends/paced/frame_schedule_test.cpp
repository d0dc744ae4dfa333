#include "backends/paced/frame_schedule.h"

#include <catch2/catch.hpp>
#include <vector>

#include "backends/paced/lateness.h"

using namespace tactus;
using namespace std::chrono_literals;

TEST_CASE("frame schedule: frame k is due at k / rate, to the nanosecond and without drift") {
  const int rate = GENERATE(1000, 3000, 10'000, 16'000, 20'000);
  const auto begin = 123'456'789ns;
  const FrameSchedule schedule{rate, begin};
  for (std::int64_t k = 0; k < 3 * rate; k += 7) {
    // ceil(k 1e9 / rate)
    const auto exact = static_cast<std::int64_t>((k * 1'000'000'000 + rate - 1) / rate);
    REQUIRE((schedule.due(k) - begin).count() == exact);
  }
  const std::int64_t days = 86'400LL * 365;
  CHECK(schedule.due(days * rate) - begin == std::chrono::seconds{days});
}

TEST_CASE(
    "frame schedule: woken when a frame is due, it has that frame, and a nanosecond earlier none later") {
  const int rate = GENERATE(1000, 3000, 12'000);
  FrameSchedule schedule{rate, 5s};
  for (std::int64_t k = 0; k < 5000; ++k) {
    const auto turn = schedule.wake(schedule.due(k + 1) - 1ns);  // as late as a frame may be
    REQUIRE(turn.frame == k);
    REQUIRE(turn.skipped == 0);
    REQUIRE(turn.late == schedule.due(k + 1) - 1ns - schedule.due(k));
  }
}

TEST_CASE("frame schedule: after a long frame the missed ones are skipped, and none share a period") {
  FrameSchedule schedule{1000, 0ns};
  CHECK(schedule.wake(0ns).frame == 0);
  const auto late = schedule.wake(3'500us);  // it waited for 1 ms
  CHECK(late.frame == 3);
  CHECK(late.skipped == 2);
  CHECK(late.late == 2'500us);
  CHECK(schedule.next_due() == 4ms);
  const auto next = schedule.wake(4ms);
  CHECK(next.frame == 4);
  CHECK(next.skipped == 0);
  CHECK(next.late == 0ns);
}

TEST_CASE("frame schedule: a wake-up before the frame is due counts as on time") {
  FrameSchedule schedule{1000, 1s};
  const auto turn = schedule.wake(900ms);
  CHECK(turn.frame == 0);
  CHECK(turn.skipped == 0);
  CHECK(turn.late == 0ns);
}

TEST_CASE("lateness: each time counts in its microsecond, and quantiles are those of the sorted times") {
  LatenessHistogram histogram;
  CHECK(histogram.quantile(0.5) == 0ns);
  std::vector<LatenessHistogram::Time> times;
  for (int n = 0; n < 1000; ++n) times.push_back(n * 1us + 300ns);  // 0.3, 1.3, … 999.3 us
  for (const auto time : times) histogram.add(time);
  histogram.add(-5us);
  histogram.add(25ms);
  CHECK(histogram.total() == 1002);
  CHECK(histogram.count(0) == 2);
  CHECK(histogram.count(1) == 1);
  CHECK(histogram.count(999) == 1);
  CHECK(histogram.count(1000) == 0);
  CHECK(histogram.count(LatenessHistogram::kBins) == 1);
  CHECK(histogram.longest() == 25ms);
  CHECK(histogram.quantile(0.5) == 500us);  // 501 of 1002 are below: -5 us and 0.3 to 499.3 us
  CHECK(histogram.quantile(1.0) == 25ms);
}
