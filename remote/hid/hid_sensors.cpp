#include "remote/hid/hid_sensors.h"

#include <SDL.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>

#include "engine/core/index.h"
#include "remote/hid/hid_map.h"
#include "remote/stream_clock.h"

namespace tactus {
namespace {

using namespace std::chrono_literals;

constexpr auto kTurn = 1ms;
constexpr int kTurnsPerLook = 500;  // for devices that came

double share_of(Sint16 axis) {
  constexpr double kLow = SDL_JOYSTICK_AXIS_MIN, kHigh = SDL_JOYSTICK_AXIS_MAX;
  return (axis - kLow) / (kHigh - kLow);
}

/// An open device, with the values that were reported.
class OpenDevice {
 public:
  /// Where its axes are now is not reported: a control moves when a person moves it.
  explicit OpenDevice(SDL_Joystick* joystick) : joystick_(joystick), name_(name_of(joystick)) {
    axes_.resize(index(std::max(0, SDL_JoystickNumAxes(joystick))));
    buttons_.resize(index(std::max(0, SDL_JoystickNumButtons(joystick))));
    read([](const HidEvent&) {});
  }
  OpenDevice(const OpenDevice&) = delete;
  OpenDevice& operator=(const OpenDevice&) = delete;
  ~OpenDevice() { SDL_JoystickClose(joystick_); }

  const std::string& name() const { return name_; }
  bool attached() const { return SDL_JoystickGetAttached(joystick_) == SDL_TRUE; }
  /// Calls `report` for everything that changed.
  template <class Report>
  void read(const Report& report) {
    for (int a = 0; a < std::ssize(axes_); ++a)
      if (const double value = share_of(SDL_JoystickGetAxis(joystick_, a));
          std::exchange(axes_[index(a)], value) != value)
        report(HidEvent{name_, HidPart::Axis, a, value});
    for (int b = 0; b < std::ssize(buttons_); ++b)
      if (const double value = SDL_JoystickGetButton(joystick_, b);
          std::exchange(buttons_[index(b)], value) != value)
        report(HidEvent{name_, HidPart::Button, b, value});
  }

 private:
  static std::string name_of(SDL_Joystick* joystick) {
    const auto* name = SDL_JoystickName(joystick);
    return name == nullptr ? "unnamed" : name;
  }

  SDL_Joystick* joystick_;
  std::string name_;
  std::vector<double> axes_, buttons_;
};

class Sensors final : public HidSensors {
 public:
  Sensors(std::string device, RemoteTarget& target) : device_(std::move(device)), target_(target) {}
  ~Sensors() override {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  Status start() {
    thread_ = std::thread{[this] { run(); }};
    std::unique_lock lock{mutex_};
    started_.wait(lock, [this] { return ready_; });
    if (error_.empty()) return {};
    return fail(Errc::Device, "--hid", "joysticks and gamepads cannot be read: " + error_, "");
  }

  std::vector<std::string> devices() const override {
    const std::lock_guard lock{mutex_};
    return names_;
  }
  std::int64_t changes() const override { return changes_; }

 private:
  void run() {
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
    const bool initialised = SDL_InitSubSystem(SDL_INIT_JOYSTICK) == 0;
    {
      const std::lock_guard lock{mutex_};
      ready_ = true;
      if (!initialised) error_ = SDL_GetError();
    }
    started_.notify_one();
    if (!initialised) return;
    for (int turn = 0; !stop_; ++turn) {
      SDL_JoystickUpdate();
      if (turn % kTurnsPerLook == 0) look();
      drop_lost();
      for (auto& [id, device] : open_) device->read([this](const HidEvent& event) { use(event); });
      std::this_thread::sleep_for(kTurn);
    }
    open_.clear();
    SDL_QuitSubSystem(SDL_INIT_JOYSTICK);
  }

  void look() {
    for (int i = 0; i < SDL_NumJoysticks(); ++i) {
      if (open_.contains(SDL_JoystickGetDeviceInstanceID(i))) continue;
      auto* joystick = SDL_JoystickOpen(i);
      if (joystick == nullptr) continue;
      auto device = std::make_unique<OpenDevice>(joystick);
      if (device->name().find(device_) == std::string::npos) continue;
      target_.report(device->name() + " is connected");
      open_[SDL_JoystickInstanceID(joystick)] = std::move(device);
      publish();
    }
  }
  void drop_lost() {
    const auto lost = std::erase_if(open_, [this](const auto& entry) {
      if (entry.second->attached()) return false;
      target_.report(entry.second->name() + " is gone: its controls stay where they are");
      map_.forget(entry.second->name());
      return true;
    });
    if (lost > 0) publish();
  }
  void publish() {
    std::vector<std::string> names;
    for (const auto& [id, device] : open_) names.push_back(device->name());
    const std::lock_guard lock{mutex_};
    names_ = std::move(names);
  }

  void use(const HidEvent& event) {
    auto orders = map_.handle(event, target_);
    for (auto& order : orders) {
      order.time_s = system_seconds() + kDelay.value;
      order.received = std::chrono::steady_clock::now();
    }
    if (!orders.empty() && target_.post(orders)) changes_ += std::ssize(orders);
  }

  std::string device_;
  RemoteTarget& target_;
  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> changes_{0};
  mutable std::mutex mutex_;
  std::condition_variable started_;
  bool ready_ = false;
  std::string error_;
  std::vector<std::string> names_;
  std::thread thread_;
  // Of the thread, which alone calls the library.
  HidMap map_;
  std::map<SDL_JoystickID, std::unique_ptr<OpenDevice>> open_;
};

}  // namespace

Result<std::unique_ptr<HidSensors>> HidSensors::open(const std::string& device, RemoteTarget& target) {
  auto sensors = std::make_unique<Sensors>(device, target);
  if (auto started = sensors->start(); !started) return tl::unexpected(started.error());
  return sensors;
}

}  // namespace tactus
