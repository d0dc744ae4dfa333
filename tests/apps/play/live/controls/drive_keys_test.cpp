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
  Key later(std::chrono::milliseconds at) { return keys.act_later(DriveKeys::Clock::time_point{at}); }
  /// One press after another, until nothing follows any more. False: none of them armed.
  bool arms(const std::vector<std::chrono::milliseconds>& presses) {
    for (std::size_t p = 0; p < presses.size(); ++p) {
      press('a', presses[p]);
      const auto end = p + 1 < presses.size() ? presses[p + 1] : presses[p] + 5s;
      for (auto now = presses[p]; now < end; now += 20ms)
        if (later(now) == kArmKey) return true;
    }
    return false;
  }
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

TEST_CASE("drive keys: two presses from 100 ms to 1 s apart arm after 150 ms, on the control thread",
          "[live]") {
  const auto apart = GENERATE(100ms, 1000ms);
  Drive drive{false};
  CHECK(drive.press('a', 5000ms) == kFirstArmKey);
  CHECK(drive.later(5099ms) == kNoKey);
  CHECK(drive.press('a', 5000ms + apart) == kNoKey);
  CHECK(drive.later(5149ms + apart) == kNoKey);
  CHECK(drive.later(5150ms + apart) == kArmKey);
  CHECK(drive.later(5170ms + apart) == kNoKey);
  CHECK_FALSE(drive.sounds());
  drive.switches.arm();
  CHECK(drive.switches.armed());
  CHECK(drive.sounds());
}

TEST_CASE("drive keys: no single byte arms, nor do two that come too late or with another beside them",
          "[live]") {
  Drive drive{false};
  CHECK(drive.press('a', 0ms) == kFirstArmKey);
  CHECK(drive.press('a', 1001ms) == kFirstArmKey);
  CHECK(drive.press(kNoKey, 1200ms) == kNoKey);
  CHECK(drive.press('a', 1300ms) == kFirstArmKey);
  CHECK(drive.press('\n', 1400ms) == '\n');
  CHECK(drive.press('a', 1500ms) == kFirstArmKey);
  CHECK(drive.press('a', 1700ms) == kNoKey);
  CHECK(drive.press('x', 1800ms) == 'x');
  CHECK(drive.later(1850ms) == kNoKey);
  drive.switches.arm();  // without an order
  CHECK_FALSE(drive.switches.armed());
  CHECK_FALSE(drive.sounds());
}

TEST_CASE("drive keys: a key that repeats does not arm, nor does a press soon after it", "[live]") {
  const auto delay = GENERATE(200ms, 500ms, 1000ms);
  const auto period = GENERATE(0ms, 33ms, 99ms, 110ms, 149ms);
  std::vector<std::chrono::milliseconds> held = {1000ms};
  for (int n = 0; n < 10; ++n) held.push_back(held.front() + delay + n * period);
  CHECK_FALSE(Drive{false}.arms(held));
  CHECK_FALSE(Drive{true}.arms(held));
  held.push_back(held.back() + 500ms);
  CHECK_FALSE(Drive{false}.arms(held));
  held.insert(held.end(), {held.back() + 1000ms, held.back() + 1300ms});
  CHECK(Drive{false}.arms(held));
}

TEST_CASE("drive keys: two presses less than 100 ms apart do not arm, and a second must pass", "[live]") {
  Drive drive{false};
  CHECK(drive.press('a', 0ms) == kFirstArmKey);
  CHECK(drive.press('a', 99ms) == kNotArmedKey);
  CHECK(drive.press('a', 1098ms) == kNotArmedKey);
  CHECK(drive.press('a', 2098ms) == kFirstArmKey);
}

TEST_CASE("drive keys: one press disarms at once, and takes an order to arm back", "[live]") {
  Drive drive{true};
  CHECK(drive.sounds());
  CHECK(drive.press('a', 0ms) == kDisarmedKey);
  CHECK_FALSE(drive.sounds());
  CHECK(drive.press('a', 1000ms) == kFirstArmKey);
  CHECK(drive.press('a', 1500ms) == kNoKey);
  CHECK(drive.later(1650ms) == kArmKey);
  CHECK(drive.press('a', 1660ms) == kDisarmedKey);  // the control thread was busy meanwhile
  drive.switches.arm();
  CHECK_FALSE(drive.switches.armed());
  CHECK_FALSE(drive.sounds());
}

TEST_CASE("drive keys: presses that follow a disarm do not arm again", "[live]") {
  CHECK_FALSE(Drive{true}.arms({0ms, 400ms, 650ms, 900ms}));
  CHECK(Drive{true}.arms({0ms, 1000ms, 1300ms}));
  Drive drive{true};
  drive.later(0ms);
  drive.switches.disarm();  // the guard, or a device that is not as it was
  drive.later(100ms);
  CHECK(drive.press('a', 110ms) == kNotArmedKey);
  CHECK(drive.press('a', 600ms) == kNotArmedKey);
  CHECK(drive.press('a', 1600ms) == kFirstArmKey);
}

TEST_CASE("drive keys: m mutes and unmutes at once", "[live]") {
  Drive drive{true};
  CHECK(drive.press('m', 0ms) == kMutedKey);
  CHECK_FALSE(drive.sounds());
  CHECK(drive.press('m', 1ms) == kUnmutedKey);
  CHECK(drive.sounds());
}
