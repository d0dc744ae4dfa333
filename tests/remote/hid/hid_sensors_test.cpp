#include "remote/hid/hid_sensors.h"

#include <SDL.h>

#include <catch2/catch.hpp>
#include <mutex>

#include "remote/stream_clock.h"
#include "tests/remote/fake_remote_target.h"
#include "tests/support/wait_until.h"

// With a device that the library simulates; devices of a kernel: tests/cards/hid.

using namespace tactus;

namespace {

class Target final : public test::FakeRemoteTarget {
 public:
  Target() {
    hid = {{"", {}, "", HidPart::Axis, 1, false}};
    describe({{"strength", ""}});
  }
  bool post(std::span<const RemoteOrder> bundle) override {
    const std::lock_guard lock{mutex_};
    posted_.emplace_back(bundle.begin(), bundle.end());
    return true;
  }
  void report(std::string text) override {
    const std::lock_guard lock{mutex_};
    reports_.push_back(std::move(text));
  }
  std::vector<std::vector<RemoteOrder>> posted() const {
    const std::lock_guard lock{mutex_};
    return posted_;
  }
  std::vector<std::string> reports() const {
    const std::lock_guard lock{mutex_};
    return reports_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::vector<RemoteOrder>> posted_;
  std::vector<std::string> reports_;
};

}  // namespace

TEST_CASE("hid sensors: a device that moves sets its control, and may come and go", "[remote]") {
  Target target;
  const auto sensors = HidSensors::open("", target);
  REQUIRE(sensors);
  for (int turn = 0; turn < 2; ++turn) {
    const auto before = target.posted().size();
    const int number = SDL_JoystickAttachVirtual(SDL_JOYSTICK_TYPE_GAMECONTROLLER, 3, 4, 0);
    REQUIRE(number >= 0);
    auto* joystick = SDL_JoystickOpen(number);
    REQUIRE(joystick != nullptr);
    REQUIRE(test::wait_until([&] { return !(*sensors)->devices().empty(); }));
    CHECK(target.posted().size() == before);  // where it is at first moves nothing
    const double time_s = system_seconds();
    REQUIRE(SDL_JoystickSetVirtualAxis(joystick, 1, SDL_JOYSTICK_AXIS_MAX) == 0);
    REQUIRE(test::wait_until([&] { return target.posted().size() == before + 1; }));
    const auto order = target.posted().back().at(0);
    CHECK(order.number == 10);
    CHECK(order.value == 1.0);
    CHECK(order.time_s >= time_s + HidSensors::kDelay.value);
    SDL_JoystickClose(joystick);
    REQUIRE(SDL_JoystickDetachVirtual(number) == 0);
    REQUIRE(test::wait_until([&] { return (*sensors)->devices().empty(); }));
  }
  CHECK((*sensors)->changes() == 2);
  const auto reports = target.reports();
  REQUIRE(reports.size() == 4);
  CHECK(reports[1].find("is gone") != std::string::npos);
}

TEST_CASE("hid sensors: only the device that is named is opened", "[remote]") {
  Target target;
  const auto sensors = HidSensors::open("no such device", target);
  REQUIRE(sensors);
  const int number = SDL_JoystickAttachVirtual(SDL_JOYSTICK_TYPE_GAMECONTROLLER, 3, 4, 0);
  REQUIRE(number >= 0);
  auto* joystick = SDL_JoystickOpen(number);
  REQUIRE(joystick != nullptr);
  SDL_JoystickClose(joystick);
  REQUIRE(SDL_JoystickDetachVirtual(number) == 0);
  CHECK((*sensors)->devices().empty());
}
