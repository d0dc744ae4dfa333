#include "apps/play/live/controls/drive_keys.h"

#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/full_scale.h"

using namespace tactus;
using namespace tactus::app;
using namespace std::chrono_literals;

namespace {

/// One drive without ramps.
struct Drive {
  explicit Drive(bool armed)
      : guarded(one, {{DriveGuard::Kind::Drive, kAtOnce}}, armed), switches(guarded, armed) {
    REQUIRE(guarded.prepare({.out_channels = 1}));
  }
  Key press(Key key, std::chrono::milliseconds at) { return keys.act(key, DriveKeys::Clock::time_point{at}); }
  bool sounds() {
    double sample = 0.0;
    double* out = &sample;
    guarded.process({nullptr, &out, 1});
    return sample == 1.0;
  }

  static constexpr DriveLimits kAtOnce{.soft_start = Seconds{0}, .fade_out = Seconds{0}};
  test::FullScale one;
  Guarded guarded;
  DriveSwitches switches;
  DriveKeys keys{switches};
};

}  // namespace

TEST_CASE("drive keys: two presses from 100 ms to 1 s apart arm, on the control thread", "[live]") {
  const auto apart = GENERATE(100ms, 1000ms);
  Drive drive{false};
  CHECK(drive.press('a', 5000ms) == kFirstArmKey);
  CHECK(drive.press('a', 5000ms + apart) == kArmKey);
  CHECK_FALSE(drive.sounds());
  drive.switches.arm();
  CHECK(drive.switches.armed());
  CHECK(drive.sounds());
}

TEST_CASE("drive keys: no single byte arms, nor do two that come too soon, too late or with another between",
          "[live]") {
  Drive drive{false};
  CHECK(drive.press('a', 0ms) == kFirstArmKey);
  CHECK(drive.press('a', 99ms) == kFirstArmKey);
  CHECK(drive.press('a', 1100ms) == kFirstArmKey);
  CHECK(drive.press(kNoKey, 1200ms) == kNoKey);
  CHECK(drive.press('a', 1300ms) == kFirstArmKey);
  CHECK(drive.press('\n', 1400ms) == '\n');
  CHECK(drive.press('a', 1500ms) == kFirstArmKey);
  drive.switches.arm();  // without an order
  CHECK_FALSE(drive.switches.armed());
  CHECK_FALSE(drive.sounds());
}

TEST_CASE("drive keys: one press disarms at once, and takes an order to arm back", "[live]") {
  Drive drive{true};
  CHECK(drive.sounds());
  CHECK(drive.press('a', 0ms) == kDisarmedKey);
  CHECK_FALSE(drive.sounds());
  CHECK(drive.press('a', 500ms) == kFirstArmKey);
  CHECK(drive.press('a', 1000ms) == kArmKey);
  CHECK(drive.press('a', 1100ms) == kDisarmedKey);  // the control thread was busy meanwhile
  drive.switches.arm();
  CHECK_FALSE(drive.switches.armed());
  CHECK_FALSE(drive.sounds());
}

TEST_CASE("drive keys: m mutes and unmutes at once", "[live]") {
  Drive drive{true};
  CHECK(drive.press('m', 0ms) == kMutedKey);
  CHECK_FALSE(drive.sounds());
  CHECK(drive.press('m', 1ms) == kUnmutedKey);
  CHECK(drive.sounds());
}
