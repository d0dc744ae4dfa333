#include "apps/render/render_events.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

using namespace tactus;
using app::EventCollector;
using app::Json;

namespace {

const std::vector<std::string> kTaps = {"a.hit", "a.level", "b.beat"};

/// Taps at 1 kHz, in blocks of these sizes in turn.
Json collected(const std::vector<std::vector<double>>& taps, const std::vector<int>& blocks) {
  EventCollector events{kTaps, 1_kHz};
  const auto frames = static_cast<int>(taps[0].size());
  for (int done = 0, turn = 0; done < frames; ++turn) {
    const int count = std::min(blocks[static_cast<std::size_t>(turn) % blocks.size()], frames - done);
    std::vector<const double*> at;
    for (const auto& tap : taps) at.push_back(tap.data() + done);
    events.add(at, count);
    done += count;
  }
  return events.json()["events"];
}

}  // namespace

TEST_CASE(
    "render events: whatever the blocks, an event has its time and the level 5 ms later or at the next one",
    "[apps]") {
  const auto blocks = GENERATE(std::vector<int>{100}, std::vector<int>{1}, std::vector<int>{3, 7, 2});
  std::vector<std::vector<double>> taps(3, std::vector<double>(40));
  for (const int hit : {4, 7, 20, 38}) taps[0][static_cast<std::size_t>(hit)] = 1;
  taps[0][21] = 1;  // it is still the same event
  for (std::size_t n = 0; n < 40; ++n) taps[1][n] = 0.01 * static_cast<double>(n);
  taps[2][7] = 1;
  const auto events = collected(taps, blocks);
  REQUIRE(events.size() == 5);
  const auto check = [&](std::size_t event, const char* node, double time_s) {
    CHECK(events[event]["node"] == node);
    CHECK(events[event]["time_s"].get<double>() == time_s);
  };
  check(0, "a", 0.004);
  check(1, "a", 0.007);
  check(2, "b", 0.007);
  check(3, "a", 0.02);
  check(4, "a", 0.038);
  const auto level = [&](std::size_t event) { return events[event]["level_db"].get<double>(); };
  CHECK(level(0) == Approx(20 * std::log10(0.07)));  // at the next one
  CHECK(level(1) == Approx(20 * std::log10(0.12)));
  CHECK(level(3) == Approx(20 * std::log10(0.25)));
  CHECK(level(4) == Approx(20 * std::log10(0.39)));  // at the end
  CHECK_FALSE(events[2].contains("level_db"));
}
