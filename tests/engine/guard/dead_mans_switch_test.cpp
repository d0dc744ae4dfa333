#include "engine/guard/dead_mans_switch.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <vector>

#include "engine/core/not_realtime.h"
#include "engine/guard/guarded.h"
#include "tests/support/full_scale.h"

using namespace tactus;
using Kind = JournalEntry::Kind;

namespace {

constexpr int kAll = JournalEntry::kAllChannels;
constexpr DriveLimits kAtOnce{.soft_start = Seconds{0}, .fade_out = Seconds{0}};

/// A drive and an audio output that observe a dead man's switch, at 48 kHz.
class Watched final : private BlockTap {
 public:
  explicit Watched(DriveLimits limits = kAtOnce)
      : guarded(one_, {{DriveGuard::Kind::Drive, limits}, {DriveGuard::Kind::Audio, limits}}) {
    guarded.set_tap(this);
    begin(dead_man);
  }
  /// A stream that this switch watches.
  void begin(const DeadMansSwitch& watching) {
    guarded.set_dead_mans_switch(&watching);
    REQUIRE(guarded.prepare({.out_channels = 2, .max_frames = 4800}));
  }
  /// Up to `frame`, in blocks of this length.
  void play_until(std::int64_t frame, int block = 4800) {
    std::vector<double> out[2] = {std::vector<double>(4800), std::vector<double>(4800)};
    double* to[] = {out[0].data(), out[1].data()};
    while (guarded.frame() < frame) {
      const auto frames = static_cast<int>(std::min<std::int64_t>(block, frame - guarded.frame()));
      guarded.process({nullptr, to, frames});
      drive.insert(drive.end(), out[0].begin(), out[0].begin() + frames);
      audio.insert(audio.end(), out[1].begin(), out[1].begin() + frames);
    }
  }
  std::vector<GuardEvent> events() {
    std::vector<GuardEvent> all;
    for (GuardEvent event; guarded.take_event(event);) all.push_back(event);
    return all;
  }

  DeadMansSwitch dead_man;
  std::vector<JournalEntry> journal;
  std::vector<double> drive, audio;

 private:
  void applied(const JournalEntry& entry) noexcept override {
    const NotRealtime allocates;
    journal.push_back(entry);
  }
  void observe(const BlockIo&, std::int64_t) noexcept override {}
  test::FullScale one_;

 public:
  Guarded guarded;
};

/// So many frames of each value.
std::vector<double> frames_of(std::initializer_list<std::pair<int, double>> spans) {
  std::vector<double> all;
  for (const auto& [frames, value] : spans) all.insert(all.end(), static_cast<std::size_t>(frames), value);
  return all;
}

}  // namespace

TEST_CASE("dead man's switch: 500 ms of frames after the last refresh every output fades, whatever the block",
          "[core]") {
  Watched watched;
  const int block = GENERATE(1, 48, 480, 4800);
  watched.play_until(4800, block);
  watched.dead_man.refresh();
  watched.play_until(33'600, block);
  CHECK(watched.drive == frames_of({{28'800, 1.0}, {4'800, 0.0}}));
  CHECK(watched.audio == watched.drive);
  CHECK(watched.journal == std::vector<JournalEntry>{{28'800, Kind::DeadMan, kAll, 1.0}});
  CHECK(watched.events() == std::vector<GuardEvent>{{28'800, GuardEvent::Kind::DeadMan, 0}});
}

TEST_CASE("dead man's switch: refreshed within 5 s, the outputs start softly", "[core]") {
  Watched watched{{.soft_start = 1_ms, .fade_out = 1_ms}};
  watched.play_until(240'000 - 4'800);
  CHECK(watched.drive[24'000 + 24] == 0.5);
  CHECK(watched.drive[24'000 + 48] == 0.0);
  watched.dead_man.refresh();
  watched.play_until(240'000);
  const auto resumed = 240'000u - 4'800u;
  CHECK(watched.drive[resumed] == 0.0);
  CHECK(watched.drive[resumed + 24] == 0.5);
  CHECK(watched.drive[resumed + 48] == 1.0);
  CHECK(watched.journal.back() == JournalEntry{235'200, Kind::DeadMan, kAll, 0.0});
}

TEST_CASE("dead man's switch: after 5 s the drives are disarmed, and audio alone comes back", "[core]") {
  Watched watched;
  watched.play_until(300'000);
  watched.dead_man.refresh();
  watched.play_until(304'800);
  CHECK(watched.drive == frames_of({{24'000, 1.0}, {280'800, 0.0}}));
  CHECK(watched.audio == frames_of({{24'000, 1.0}, {276'000, 0.0}, {4'800, 1.0}}));
  CHECK(watched.journal == std::vector<JournalEntry>{{24'000, Kind::DeadMan, kAll, 1.0},
                                                     {240'000, Kind::Arm, kAll, 0.0},
                                                     {300'000, Kind::DeadMan, kAll, 0.0}});
  CHECK(watched.events() == std::vector<GuardEvent>{{24'000, GuardEvent::Kind::DeadMan, 0},
                                                    {240'000, GuardEvent::Kind::DeadManDisarmed, 0}});
  watched.guarded.arm(true);
  watched.play_until(309'600);
  CHECK(watched.drive.back() == 1.0);
}

TEST_CASE("dead man's switch: refreshed in time nothing happens, and without one nothing ever does",
          "[core]") {
  Watched watched;
  const bool used = GENERATE(true, false);
  if (!used) {
    watched.guarded.set_dead_mans_switch(nullptr);
    REQUIRE(watched.guarded.prepare({.out_channels = 2, .max_frames = 4800}));
  }
  for (std::int64_t frame = 19'200; frame < 480'000; frame += 19'200) {
    watched.play_until(frame);
    if (used) watched.dead_man.refresh();
  }
  CHECK(watched.drive == std::vector<double>(watched.drive.size(), 1.0));
  CHECK(watched.journal.empty());
}

TEST_CASE("dead man's switch: the longest pause is remembered, and one that still lasts counts", "[core]") {
  using namespace std::chrono_literals;
  static std::chrono::nanoseconds now;
  now = 7s;
  DeadMansSwitch dead_man{[] { return now; }};
  now += 60ms;
  CHECK(dead_man.longest_pause().value == 0.06);
  dead_man.refresh();
  now += 20ms;
  CHECK(dead_man.longest_pause().value == 0.06);
  dead_man.refresh();
  now += 80ms;
  CHECK(dead_man.longest_pause().value == 0.08);
}

TEST_CASE("dead man's switch: where device and program stood still together for 5 s, drives are disarmed",
          "[core]") {
  static std::chrono::nanoseconds now;
  const auto [seconds, disarms] = GENERATE(std::pair{4.9, false}, std::pair{5.1, true});
  Watched watched;
  DeadMansSwitch dead_man{[] { return now; }};
  watched.begin(dead_man);
  watched.play_until(4'800);
  now += std::chrono::nanoseconds{static_cast<std::int64_t>(1e9 * seconds)};  // no block comes meanwhile
  for (int i = 0; i < 50; ++i) dead_man.refresh();  // the program goes on before the device does
  watched.play_until(14'400);
  CHECK(watched.drive.back() == (disarms ? 0.0 : 1.0));
  CHECK(watched.events().size() == (disarms ? 1 : 0));
  watched.guarded.arm(true);
  dead_man.refresh();
  watched.play_until(19'200);
  CHECK(watched.drive.back() == 1.0);
}

TEST_CASE("dead man's switch: a device that returns finds it expired if it was not refreshed meanwhile",
          "[core]") {
  static std::chrono::nanoseconds now;
  const auto [away_s, silent] = GENERATE(std::pair{0.45, false}, std::pair{0.55, true});
  Watched watched;
  DeadMansSwitch dead_man{[] { return now; }};
  watched.begin(dead_man);
  watched.play_until(4'800);
  now += std::chrono::nanoseconds{static_cast<std::int64_t>(1e9 * away_s)};
  watched.begin(dead_man);
  watched.drive.clear();
  watched.play_until(4'800);
  CHECK(watched.drive == frames_of({{4'800, silent ? 0.0 : 1.0}}));
  dead_man.refresh();
  watched.play_until(9'600);
  CHECK(watched.drive.back() == 1.0);
}

TEST_CASE("dead man's switch: stopped, every output fades in the next block, for good", "[core]") {
  Watched watched;
  watched.play_until(4'800);
  watched.dead_man.stop();
  watched.play_until(9'600);
  watched.guarded.fade(false);
  watched.dead_man.refresh();
  watched.play_until(14'400);
  CHECK(watched.drive == frames_of({{4'800, 1.0}, {9'600, 0.0}}));
  CHECK(watched.journal.front() == JournalEntry{4'800, Kind::Fade, kAll, 1.0});
  CHECK(watched.guarded.silent());
}

TEST_CASE("dead man's switch: what expired stays so when the stream begins again", "[core]") {
  Watched watched;
  watched.play_until(28'800);
  REQUIRE(watched.guarded.prepare({.out_channels = 2, .max_frames = 4800}));
  CHECK(watched.guarded.state() == std::vector<JournalEntry>{{0, Kind::DeadMan, kAll, 1.0}});
  watched.drive.clear();
  watched.play_until(4'800);
  watched.dead_man.refresh();
  watched.play_until(9'600);
  CHECK(watched.drive == frames_of({{4'800, 0.0}, {4'800, 1.0}}));
}

TEST_CASE(
    "dead man's switch: a program that was stopped for 5 s comes back disarmed, one that waited does not",
    "[core]") {
  // No frame passes meanwhile. A loop that runs refreshes it many times a second.
  struct Case {
    double pause_s;
    int refreshes;
    bool disarms;
  };
  const auto each =
      GENERATE(Case{5.0, 0, true}, Case{60.0, 1, true}, Case{4.9, 0, false}, Case{6.0, 300, false});
  CAPTURE(each.pause_s, each.refreshes);
  Watched watched;
  watched.play_until(4800);
  for (int n = 0; n < each.refreshes; ++n) watched.dead_man.refresh();
  watched.guarded.note_pause(Seconds{each.pause_s});
  watched.play_until(9600);
  const auto events = watched.events();
  CHECK(watched.drive.back() == (each.disarms ? 0.0 : 1.0));
  CHECK(watched.audio.back() == 1.0);
  REQUIRE(events.size() == (each.disarms ? 1 : 0));
  if (each.disarms) CHECK(events[0].kind == GuardEvent::Kind::DeadManDisarmed);
}
