// A gamepad of a real kernel, made with uinput.
#include <fcntl.h>
#include <linux/uinput.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <mutex>

#include "remote/hid/hid_sensors.h"
#include "tests/remote/fake_remote_target.h"
#include "tests/support/wait_until.h"

using namespace tactus;
using test::wait_until;
using namespace std::chrono_literals;

namespace {

constexpr std::chrono::milliseconds kSlowMachine = 120s;

/// Two axes from -512 to 511 and two buttons.
class Gamepad {
 public:
  Gamepad() : file_(open("/dev/uinput", O_WRONLY)) {
    REQUIRE(file_ >= 0);
    for (const int type : {EV_KEY, EV_ABS}) REQUIRE(ioctl(file_, UI_SET_EVBIT, type) == 0);
    for (const int key : {BTN_SOUTH, BTN_EAST}) REQUIRE(ioctl(file_, UI_SET_KEYBIT, key) == 0);
    for (const int axis : {ABS_X, ABS_Y}) {
      uinput_abs_setup setup{};
      setup.code = static_cast<std::uint16_t>(axis);
      setup.absinfo.minimum = -512;
      setup.absinfo.maximum = 511;
      REQUIRE(ioctl(file_, UI_ABS_SETUP, &setup) == 0);
    }
    uinput_setup setup{};
    setup.id.bustype = BUS_USB;
    setup.id.vendor = 0x1209;
    setup.id.product = 0x0001;
    std::strcpy(setup.name, "Test Gamepad");
    REQUIRE(ioctl(file_, UI_DEV_SETUP, &setup) == 0);
    REQUIRE(ioctl(file_, UI_DEV_CREATE) == 0);
  }
  ~Gamepad() {
    ioctl(file_, UI_DEV_DESTROY);
    close(file_);
  }
  void move(int axis, int value) { emit(EV_ABS, axis, value); }
  void press(int key, bool down) { emit(EV_KEY, key, down ? 1 : 0); }

 private:
  void emit(int type, int code, int value) {
    for (const auto& [t, c, v] : {std::array{type, code, value}, std::array{EV_SYN, SYN_REPORT, 0}}) {
      input_event event{};
      event.type = static_cast<std::uint16_t>(t);
      event.code = static_cast<std::uint16_t>(c);
      event.value = v;
      REQUIRE(write(file_, &event, sizeof event) == sizeof event);
    }
  }
  int file_;
};

class Target final : public test::FakeRemoteTarget {
 public:
  Target() {
    hid = {{"", {}, "Test", HidPart::Axis, 1, false}, {"", {}, "", HidPart::Button, 0, false}};
    describe({{"strength", ""}, {"hold", "ms"}});
  }
  bool post(std::span<const RemoteOrder> bundle) override {
    const std::lock_guard lock{mutex_};
    for (const auto& order : bundle) last_[order.number] = order.value;
    return true;
  }
  void report(std::string) override {}
  double last(int number) const {
    const std::lock_guard lock{mutex_};
    const auto found = last_.find(number);
    return found == last_.end() ? -1.0 : found->second;
  }

 private:
  mutable std::mutex mutex_;
  std::map<int, double> last_;
};

}  // namespace

TEST_CASE("hid: a gamepad moves controls, is unplugged, and plugged in again", "[.alsa]") {
  Target target;
  const auto sensors = HidSensors::open("Test Gamepad", target);
  REQUIRE(sensors);
  for (int turn = 0; turn < 3; ++turn) {
    {
      Gamepad gamepad;
      REQUIRE(wait_until([&] { return (*sensors)->devices().size() == 1; }, kSlowMachine));
      gamepad.move(ABS_Y, 511);
      REQUIRE(wait_until([&] { return target.last(10) == 1.0; }, kSlowMachine));
      gamepad.move(ABS_Y, -512);
      REQUIRE(wait_until([&] { return target.last(10) == 0.0; }, kSlowMachine));
      gamepad.press(BTN_SOUTH, true);
      REQUIRE(wait_until([&] { return target.last(11) == Approx(0.1); }, kSlowMachine));
      gamepad.press(BTN_SOUTH, false);
      REQUIRE(wait_until([&] { return target.last(11) == Approx(0.002); }, kSlowMachine));
    }
    REQUIRE(wait_until([&] { return (*sensors)->devices().empty(); }, kSlowMachine));
  }
}
