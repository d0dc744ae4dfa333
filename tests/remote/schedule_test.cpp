#include "remote/schedule.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

using namespace tactus;
using Kind = JournalEntry::Kind;

namespace {

constexpr double kStart_s = 1.8e9;
constexpr int kBlock = 64;

RemoteOrder set(int number, double value, double ramp_s = 0.0, double time_s = RemoteOrder::kNow) {
  return {.number = number, .value = value, .ramp_s = ramp_s, .time_s = time_s, .received = {}};
}

/// Ten controls from 0 to 1, on a stream of 48 kHz that began at kStart_s.
class Controls final : public ScheduleTarget {
 public:
  Controls() { run(30 * kBlock); }

  std::optional<ScheduledControl> control(int number) const override {
    if (number < 0 || number > 9) return std::nullopt;
    const auto value = values.find(number);
    return ScheduledControl{value == values.end() ? 0.0 : value->second, 0.0, 1.0, smooth_s, decibel};
  }
  void note(int number, double value) override { values[number] = value; }
  void gesture(int number, double value) override { gestures.emplace_back(number, value); }
  bool post(const JournalEntry& entry) override {
    if (!room) return false;
    REQUIRE((posted.empty() || entry.frame >= posted.back().frame));  // else it is held up, or late
    REQUIRE(entry.frame >= frame + 2 * kBlock);
    posted.push_back(entry);
    return true;
  }
  /// Block by block.
  void run(std::int64_t frames) {
    for (const auto end = frame + frames; frame < end;) {
      frame += kBlock;
      clock.update(kStart_s + static_cast<double>(frame) / 48'000, frame);
      schedule.advance(clock, frame, frame + 2 * kBlock);
    }
  }
  double time_of(std::int64_t at) const { return kStart_s + static_cast<double>(at) / 48'000; }
  /// Of one control.
  std::vector<JournalEntry> entries(int number) const {
    std::vector<JournalEntry> all;
    for (const auto& entry : posted)
      if (entry.index == number) all.push_back(entry);
    return all;
  }

  double smooth_s = 0.01;
  bool decibel = false, room = true;
  std::int64_t frame = 0;
  std::map<int, double> values;
  std::vector<std::pair<int, double>> gestures;
  std::vector<JournalEntry> posted;
  StreamClock clock{48_kHz};
  RemoteSchedule schedule{48_kHz, *this};
};

void add(Controls& controls, std::vector<RemoteOrder> bundle) { REQUIRE(controls.schedule.add(bundle)); }

}  // namespace

TEST_CASE("remote schedule: all orders of a bundle get one frame, and values are clamped", "[remote]") {
  Controls controls;
  add(controls, {set(0, 0.5), set(1, 7.0), set(2, -7.0), set(99, 0.5)});
  controls.run(kBlock);
  REQUIRE(controls.posted.size() == 3);
  for (const auto& entry : controls.posted) {
    CHECK(entry.frame == controls.posted[0].frame);
    CHECK(entry.kind == Kind::ControlChange);
  }
  CHECK(controls.values == std::map<int, double>{{0, 0.5}, {1, 1.0}, {2, 0.0}});
}

TEST_CASE("remote schedule: a bundle with a time tag lands on its frame", "[remote]") {
  Controls controls;
  const auto at = controls.frame + 4801;
  add(controls, {set(0, 0.25, 0, controls.time_of(at + 4800))});
  add(controls, {set(0, 0.5, 0, controls.time_of(at)), set(1, 0.5, 0, controls.time_of(at))});
  add(controls, {set(2, 0.5)});
  controls.run(9 * 4800 / 10);
  CHECK(controls.posted.size() == 3);  // it is posted 20 ms before
  controls.run(4800);
  REQUIRE(controls.posted.size() == 4);
  CHECK(controls.posted[1].frame == at);
  CHECK(controls.posted[2].frame == at);
  CHECK(controls.posted[3].frame == at + 4800);
  CHECK(controls.schedule.late() == 0);
}

TEST_CASE("remote schedule: a bundle that comes after its time is applied at once, and counted", "[remote]") {
  Controls controls;
  add(controls, {set(0, 0.5, 0, controls.time_of(controls.frame - 100)), set(1, 0.5)});
  controls.run(kBlock);
  CHECK(controls.posted.size() == 2);
  CHECK(controls.schedule.late() == 1);
}

TEST_CASE("remote schedule: a ramp is a straight line that ends at its time", "[remote]") {
  Controls controls;
  controls.smooth_s = GENERATE(0.0, 0.01, 0.1);
  controls.decibel = GENERATE(false, true);
  const double ramp_s = GENERATE(0.05, 1.0);
  CAPTURE(controls.smooth_s, controls.decibel, ramp_s);
  controls.values[3] = 0.01;
  const auto start = controls.frame + 4800;
  add(controls, {set(3, 1.0, ramp_s, controls.time_of(start))});
  controls.run(48'000 * 2);
  const auto points = controls.entries(3);
  REQUIRE(!points.empty());
  CHECK(points.front().frame == start);
  CHECK(points.back().value == 1.0);
  const auto frames = std::max(ramp_s, controls.smooth_s) * 48'000;
  // The control's own ramp, or what stands for it, is what takes it from one point to the next.
  const auto step = points.size() > 1 ? static_cast<double>(points[1].frame - points[0].frame) : frames;
  CHECK(static_cast<double>(points.back().frame - start) + step == Approx(frames).margin(1 + step / 2));
  double worst = 0.0;
  for (const auto& point : points) {
    const double share =
        (static_cast<double>(point.frame - start) + step) / (step * static_cast<double>(points.size()));
    const double line = controls.decibel ? 0.01 * std::pow(100.0, share) : 0.01 + 0.99 * share;
    worst = std::max(worst, std::abs(point.value - line));
  }
  CHECK(worst < 1e-9);
}

TEST_CASE("remote schedule: another change ends a ramp", "[remote]") {
  Controls controls;
  add(controls, {set(3, 1.0, 10.0)});
  controls.run(4800);
  const std::string by = GENERATE(as<std::string>{}, "order", "call", "key");
  CAPTURE(by);
  if (by == "order") add(controls, {set(3, 0.0)});
  if (by == "call") controls.schedule.end_ramp(3);
  if (by == "key") controls.values[3] = 0.77;
  controls.run(4800);
  const auto so_far = controls.posted.size();
  controls.run(4800);
  CHECK(controls.posted.size() == so_far);
}

TEST_CASE("remote schedule: a trigger is 1 for one frame, and two of them are two", "[remote]") {
  Controls controls;
  for (int n = 0; n < 2; ++n) {
    RemoteOrder trigger = set(4, 0.0);
    trigger.kind = RemoteOrder::Kind::Trigger;
    add(controls, {trigger});
  }
  controls.run(kBlock);
  const auto entries = controls.entries(4);
  REQUIRE(entries.size() == 4);
  for (std::size_t n = 0; n < 4; ++n) {
    CHECK(entries[n].kind == Kind::ControlSet);
    CHECK(entries[n].value == (n % 2 == 0 ? 1.0 : 0.0));
  }
  CHECK(entries[1].frame == entries[0].frame + 1);
  CHECK(entries[2].frame > entries[1].frame);
  CHECK(entries[3].frame == entries[2].frame + 1);
}

TEST_CASE("remote schedule: what the player has no room for keeps its distances", "[remote]") {
  Controls controls;
  RemoteOrder trigger = set(4, 0.0);
  trigger.kind = RemoteOrder::Kind::Trigger;
  controls.room = false;
  add(controls, {trigger});
  controls.run(48'000);
  CHECK(controls.posted.empty());
  controls.room = true;
  controls.run(kBlock);
  REQUIRE(controls.posted.size() == 2);
  CHECK(controls.posted[1].frame == controls.posted[0].frame + 1);
}

TEST_CASE("remote schedule: it holds no more than 4096 orders", "[remote]") {
  Controls controls;
  const double later_s = controls.time_of(controls.frame) + 9.0;
  const std::vector<RemoteOrder> bundle(512, set(0, 0.5, 0, later_s));
  int taken = 0;
  while (controls.schedule.add(bundle)) ++taken;
  CHECK(taken == 8);
  controls.run(9 * 48'000 + 4800);
  CHECK(controls.schedule.add(bundle));
}

TEST_CASE("remote schedule: when frames are counted from 0 again, bundles keep their time", "[remote]") {
  Controls controls;
  add(controls, {set(0, 0.5, 10.0)});
  add(controls, {set(1, 0.5, 0, controls.time_of(controls.frame + 48'000))});
  controls.run(4800);
  const double now_s = controls.time_of(controls.frame);
  controls.posted.clear();
  controls.frame = 0;
  controls.clock.restart();
  controls.schedule.restart();
  while (controls.posted.empty() && controls.frame < 96'000) {
    controls.frame += kBlock;
    controls.clock.update(now_s + static_cast<double>(controls.frame) / 48'000, controls.frame);
    controls.schedule.advance(controls.clock, controls.frame, controls.frame + 2 * kBlock);
  }
  REQUIRE(controls.posted.size() == 1);  // the ramp is dropped
  CHECK(controls.posted[0].index == 1);
  CHECK(controls.posted[0].frame == Approx(48'000 - 4800).margin(1));
}
