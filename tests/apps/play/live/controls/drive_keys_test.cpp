#include "apps/play/live/controls/drive_keys.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <utility>
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
  Key press(Key key, std::chrono::milliseconds at) {
    return keys.act(key, DriveKeys::Clock::time_point{rested + at});
  }
  void turn(std::chrono::milliseconds at) { keys.begin_turn(DriveKeys::Clock::time_point{rested + at}); }
  /// Nothing is pressed for an hour.
  void rest() { rested += 1h; }
  /// Of these, all from `rested` on: does any arm?
  bool arms(const std::vector<std::pair<Key, std::chrono::milliseconds>>& presses) {
    rest();
    return std::ranges::any_of(presses,
                               [&](const auto& next) { return press(next.first, next.second) == kArmKey; });
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
  std::chrono::milliseconds rested{0};
};

constexpr Key kEnter = '\n';

}  // namespace

// What somebody else requested to arm is void once a drive was disarmed.
TEST_CASE("drive keys: an a that finds the drives disarmed disarms them once more", "[live]") {
  const auto key = GENERATE(as<Key>{}, 'a', kDisarmKey);
  Drive drive{false};
  const int before = drive.switches.disarms();
  drive.press(key, 5000ms);
  CHECK(drive.switches.disarms() == before + 1);
  drive.turn(5050ms);
  CHECK((drive.press(kEnter, 5200ms) == kArmKey) == (key == 'a'));
}

TEST_CASE("drive keys: a, then Enter from 100 ms to 3 s after it, arm on the control thread", "[live]") {
  const auto apart = GENERATE(100ms, 3000ms);
  const auto enter = GENERATE(as<Key>{}, '\n', '\r');
  Drive drive{false};
  CHECK(drive.press('a', 5000ms) == kPressEnterKey);
  CHECK(drive.press(enter, 5000ms + apart) == kArmKey);
  CHECK_FALSE(drive.sounds());
  drive.switches.arm();
  CHECK(drive.switches.armed());
  CHECK(drive.sounds());
}

TEST_CASE("drive keys: no key that is held down arms, however it repeats", "[live]") {
  const auto key = GENERATE(as<Key>{}, 'a', kEnter);
  const auto delay = GENERATE(200ms, 500ms, 1000ms);
  const auto period = GENERATE(0ms, 33ms, 99ms, 110ms, 500ms);
  std::vector<std::pair<Key, std::chrono::milliseconds>> held = {{key, 1000ms}};
  for (int n = 0; n < 40; ++n) held.push_back({key, 1000ms + delay + n * period});
  held.push_back({key, held.back().second + 300ms});  // a pause
  CHECK_FALSE(Drive{false}.arms(held));
  CHECK_FALSE(Drive{true}.arms(held));
}

TEST_CASE("drive keys: more than one a, or one that is held down, does not arm with Enter", "[live]") {
  const auto apart = GENERATE(0ms, 33ms, 100ms, 200ms, 500ms, 999ms);
  const auto many = GENERATE(2, 3, 20);
  std::vector<std::pair<Key, std::chrono::milliseconds>> presses;
  for (int n = 0; n < many; ++n) presses.push_back({Key{'a'}, n * apart});
  presses.push_back({kEnter, presses.back().second + 300ms});
  CHECK_FALSE(Drive{false}.arms(presses));
  CHECK_FALSE(Drive{true}.arms(presses));
  Drive drive{false};
  CHECK(drive.press('a', 0ms) == kPressEnterKey);
  CHECK(drive.press('a', 500ms) == kNotArmedKey);
  CHECK(drive.press('a', 533ms) == kNoKey);  // held: reported once
  CHECK(drive.press('a', 1533ms) == kPressEnterKey);
}

TEST_CASE("drive keys: Enter too soon or too late does not arm, nor with another byte between", "[live]") {
  Drive drive{false};
  CHECK(drive.press(kEnter, 0ms) == kEnter);
  CHECK(drive.press('a', 1000ms) == kPressEnterKey);
  CHECK(drive.press(kEnter, 1099ms) == kNotArmedKey);
  CHECK(drive.press(kEnter, 1300ms) == kEnter);
  CHECK(drive.press('a', 3000ms) == kPressEnterKey);
  CHECK(drive.press(kEnter, 6001ms) == kNotArmedKey);
  for (const Key other : {Key{'x'}, kNoKey, kDisarmKey, kUpKey}) {
    CAPTURE(other);
    CHECK_FALSE(drive.arms({{'a', 0ms}, {other, 300ms}, {kEnter, 600ms}}));
  }
  drive.switches.arm();  // without an order
  CHECK_FALSE(drive.switches.armed());
  CHECK_FALSE(drive.sounds());
}

TEST_CASE("drive keys: text that is typed, or pasted slowly, does not arm", "[live]") {
  const auto apart = GENERATE(0ms, 33ms, 100ms, 300ms, 900ms);
  for (const std::string text : {"ls -la\n", "data are\na\naa\n\n", "q a\n", "\na\n", "aa\n"}) {
    std::vector<std::pair<Key, std::chrono::milliseconds>> typed = {{'x', 0ms}};
    for (const char byte : text) typed.push_back({Key{byte}, typed.back().second + apart});
    CAPTURE(text, apart.count());
    CHECK_FALSE(Drive{false}.arms(typed));
  }
}

TEST_CASE("drive keys: an a within a second after another byte is not counted", "[live]") {
  const auto other = GENERATE(as<Key>{}, 'x', kNoKey, kDisarmKey, kUpKey, kEnter);
  Drive drive{false};
  drive.press(other, 0ms);
  CHECK(drive.press('a', 999ms) == kNotArmedKey);
  CHECK(drive.press('a', 1998ms) == kNotArmedKey);
  CHECK(drive.press(kEnter, 2200ms) == kEnter);
  drive.rest();
  drive.press(other, 0ms);
  CHECK(drive.press('a', 1000ms) == kPressEnterKey);
}

TEST_CASE("drive keys: one press disarms at once, and takes an order to arm back", "[live]") {
  const auto press = GENERATE(as<Key>{}, 'a', kDisarmKey);
  Drive drive{true};
  CHECK(drive.sounds());
  CHECK(drive.press(press, 0ms) == kDisarmedKey);
  CHECK_FALSE(drive.sounds());
  CHECK(drive.press('a', 1000ms) == kPressEnterKey);
  CHECK(drive.press(kEnter, 1500ms) == kArmKey);
  CHECK(drive.press(press, 1510ms) == kDisarmedKey);  // the control thread was busy meanwhile
  drive.switches.arm();
  CHECK_FALSE(drive.switches.armed());
  CHECK_FALSE(drive.sounds());
}

TEST_CASE("drive keys: presses that follow a disarm do not arm again", "[live]") {
  CHECK_FALSE(Drive{true}.arms({{'a', 0ms}, {'a', 400ms}, {kEnter, 800ms}}));
  CHECK(Drive{true}.arms({{'a', 0ms}, {'a', 1000ms}, {kEnter, 1300ms}}));
  Drive drive{true};
  drive.turn(0ms);
  drive.switches.disarm();  // the guard, or a device that is not as it was
  drive.turn(100ms);
  CHECK(drive.press('a', 110ms) == kNotArmedKey);
  CHECK(drive.press(kEnter, 600ms) == kEnter);
  CHECK(drive.press('a', 1600ms) == kPressEnterKey);
  drive.switches.disarm();
  CHECK(drive.press(kEnter, 2000ms) == kEnter);
}

TEST_CASE("drive keys: keys that waited while the program was stopped do not arm", "[live]") {
  using Times = std::array<std::chrono::milliseconds, 5>;  // x; the turns before and of a, of Enter
  const auto armed_by = [](const Times& at) {
    Drive drive{false};
    drive.turn(at[0]);
    drive.press('x', at[0]);
    drive.turn(at[1]);
    drive.turn(at[2]);
    drive.press('a', at[2]);
    drive.turn(at[3]);
    drive.turn(at[4]);
    return drive.press(kEnter, at[4]) == kArmKey;
  };
  CHECK(armed_by({0ms, 1000ms, 1020ms, 1120ms, 1140ms}));
  CHECK(armed_by({0ms, 1000ms, 1020ms, 3980ms, 4000ms}));
  CHECK_FALSE(armed_by({0ms, 999ms, 1400ms, 1600ms, 1620ms}));   // a may be too near to the x
  CHECK_FALSE(armed_by({0ms, 1000ms, 1020ms, 1119ms, 1500ms}));  // Enter may be too near to the a
  CHECK_FALSE(armed_by({0ms, 1000ms, 1020ms, 1021ms, 1470ms}));  // stopped right after the a
  CHECK_FALSE(armed_by({0ms, 1000ms, 3900ms, 3999ms, 4020ms}));  // a may be 3.02 s old
}

TEST_CASE("drive keys: m mutes and unmutes at once", "[live]") {
  Drive drive{true};
  CHECK(drive.press('m', 0ms) == kMutedKey);
  CHECK_FALSE(drive.sounds());
  CHECK(drive.press('m', 1ms) == kUnmutedKey);
  CHECK(drive.sounds());
}
