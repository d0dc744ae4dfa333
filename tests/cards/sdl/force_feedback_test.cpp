// A wheel with force feedback of a real kernel, made with uinput, which gets what is uploaded and played.
#include <fcntl.h>
#include <linux/uinput.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include "backends/reconnecting_stream.h"
#include "tests/cards/sdl/levels.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr int kSlots = 11;  // those of its ten effects, and one for both motors
constexpr std::size_t kForceX = 2, kSpring = 5;

class Wheel {
 public:
  Wheel() : file_(open("/dev/uinput", O_RDWR | O_NONBLOCK)) {
    REQUIRE(file_ >= 0);
    for (const int type : {EV_KEY, EV_ABS, EV_FF}) REQUIRE(ioctl(file_, UI_SET_EVBIT, type) == 0);
    for (const int key : {BTN_TRIGGER, BTN_THUMB}) REQUIRE(ioctl(file_, UI_SET_KEYBIT, key) == 0);
    for (const int effect : {FF_CONSTANT, FF_SPRING, FF_DAMPER, FF_INERTIA, FF_FRICTION, FF_PERIODIC, FF_SINE,
                             FF_TRIANGLE, FF_SAW_UP, FF_SAW_DOWN})
      REQUIRE(ioctl(file_, UI_SET_FFBIT, effect) == 0);
    for (const int axis : {ABS_X, ABS_Y}) {
      uinput_abs_setup setup{};
      setup.code = static_cast<std::uint16_t>(axis);
      setup.absinfo.minimum = -32768;
      setup.absinfo.maximum = 32767;
      REQUIRE(ioctl(file_, UI_ABS_SETUP, &setup) == 0);
    }
    uinput_setup setup{};
    setup.id.bustype = BUS_USB;
    setup.id.vendor = 0x1209;
    setup.id.product = 0x0002;
    setup.ff_effects_max = kSlots;
    std::strcpy(setup.name, "Test Wheel");
    REQUIRE(ioctl(file_, UI_DEV_SETUP, &setup) == 0);
    REQUIRE(ioctl(file_, UI_DEV_CREATE) == 0);
    thread_ = std::thread{[this] { answer(); }};
  }
  ~Wheel() {
    stop_ = true;
    thread_.join();
    ioctl(file_, UI_DEV_DESTROY);
    close(file_);
  }
  void move(int axis, int value) {
    for (const auto& [type, code, to] :
         {std::array{EV_ABS, axis, value}, std::array{EV_SYN, SYN_REPORT, 0}}) {
      input_event event{};
      event.type = static_cast<std::uint16_t>(type);
      event.code = static_cast<std::uint16_t>(code);
      event.value = to;
      REQUIRE(write(file_, &event, sizeof event) == sizeof event);
    }
  }
  /// The effect of this type that was uploaded last.
  std::optional<ff_effect> uploaded(int type) const {
    const std::lock_guard lock{mutex_};
    for (const auto& [id, effect] : effects_)
      if (effect.type == type) return effect;
    return std::nullopt;
  }
  bool plays(int type) const {
    const auto effect = uploaded(type);
    const std::lock_guard lock{mutex_};
    return effect && playing_.contains(effect->id) && playing_.at(effect->id);
  }
  int uploads(int type) const {
    const std::lock_guard lock{mutex_};
    const auto found = uploads_.find(type);
    return found == uploads_.end() ? 0 : found->second;
  }
  std::size_t slots_in_use() const {
    const std::lock_guard lock{mutex_};
    return effects_.size();
  }

 private:
  void answer() {
    while (!stop_) {
      pollfd waits{file_, POLLIN, 0};
      if (poll(&waits, 1, 20) <= 0) continue;
      for (input_event event; read(file_, &event, sizeof event) == sizeof event;) take(event);
    }
  }
  void take(const input_event& event) {
    if (event.type == EV_FF) {
      const std::lock_guard lock{mutex_};
      playing_[event.code] = event.value != 0;
    }
    if (event.type != EV_UINPUT) return;
    if (event.code == UI_FF_UPLOAD) {
      uinput_ff_upload upload{};
      upload.request_id = static_cast<std::uint32_t>(event.value);
      ioctl(file_, UI_BEGIN_FF_UPLOAD, &upload);
      {
        const std::lock_guard lock{mutex_};
        effects_[upload.effect.id] = upload.effect;
        ++uploads_[upload.effect.type];
      }
      upload.retval = 0;
      ioctl(file_, UI_END_FF_UPLOAD, &upload);
    } else if (event.code == UI_FF_ERASE) {
      uinput_ff_erase erase{};
      erase.request_id = static_cast<std::uint32_t>(event.value);
      ioctl(file_, UI_BEGIN_FF_ERASE, &erase);
      {
        const std::lock_guard lock{mutex_};
        effects_.erase(static_cast<int>(erase.effect_id));
      }
      erase.retval = 0;
      ioctl(file_, UI_END_FF_ERASE, &erase);
    }
  }

  int file_;
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;
  std::map<int, ff_effect> effects_;
  std::map<int, bool> playing_;
  std::map<int, int> uploads_;
  std::thread thread_;
};

Device wheel_of(Backend& backend) { return listed(backend, "sdl:Test Wheel", kMostOutputs); }

}  // namespace

TEST_CASE("sdl: forces and effects of a wheel are uploaded, changed, played and stopped", "[.alsa]") {
  Wheel wheel;
  const auto backend = sdl();
  const auto device = wheel_of(*backend);
  CHECK(device.in_names == std::vector<std::string>{"axis 0", "axis 1", "button 0", "button 1"});
  std::vector<std::string> names{"rumble low", "rumble high", "force x",     "force y",
                                 "sine",       "spring",      "damper",      "inertia",
                                 "friction",   "triangle",    "sawtooth up", "sawtooth down"};
  for (const std::string wave : {"sine", "triangle", "sawtooth up", "sawtooth down"})
    for (const auto& setting : kWaveSettings) names.push_back(wave + " " + setting.name);
  CHECK(device.out_names == names);
  Levels levels;
  Guarded guarded{levels, unguarded(device)};
  guarded.disable_sensor_watch();
  auto stream = backend->open(request_for(device), guarded);
  REQUIRE(stream);
  REQUIRE((*stream)->start());
  wheel.move(ABS_X, 16384);
  CHECK(waits([&] { return std::abs(levels.input - 0.5) < 1e-3; }));

  levels.levels[kForceX] = -0.5;  // streamed
  REQUIRE(waits([&] { return wheel.plays(FF_CONSTANT); }));
  CHECK(wheel.uploaded(FF_CONSTANT)->u.constant.level == Approx(-16384).margin(2));
  CHECK(wheel.uploaded(FF_CONSTANT)->direction == 0xc000);  // a positive level pushes right: linux/input.h
  const int before = wheel.uploads(FF_CONSTANT);
  levels.levels[kForceX] = 0.25;
  REQUIRE(waits([&] { return wheel.uploads(FF_CONSTANT) > before; }));
  CHECK(wheel.uploaded(FF_CONSTANT)->replay.length == 500);  // a program that hangs pushes no longer

  levels.levels[kSpring] = 0.75;  // the loop of the spring is in the device
  REQUIRE(waits([&] { return wheel.plays(FF_SPRING); }));
  CHECK(wheel.uploaded(FF_SPRING)->u.condition[0].right_coeff == Approx(0.75 * 32767).margin(2));
  for (const std::size_t other : {0u, 3u, 4u, 6u, 7u, 8u, 9u, 10u, 11u}) levels.levels[other] = 0.5;
  REQUIRE(
      waits([&] { return wheel.plays(FF_FRICTION) && wheel.plays(FF_PERIODIC) && wheel.plays(FF_INERTIA); }));
  CHECK(waits([&] { return wheel.slots_in_use() == kSlots; }));

  levels.levels[kSpring] = 0.0;
  CHECK(waits([&] { return !wheel.plays(FF_SPRING); }));
  CHECK(wheel.plays(FF_DAMPER));
  REQUIRE((*stream)->stop());
  CHECK(waits(
      [&] { return !wheel.plays(FF_CONSTANT) && !wheel.plays(FF_DAMPER) && !wheel.plays(FF_FRICTION); }));
}

TEST_CASE("sdl: waves of a wheel have shape and period and offset and envelope", "[.alsa]") {
  Wheel wheel;
  const auto backend = sdl();
  const auto device = wheel_of(*backend);
  Levels levels;
  const auto level = [&](const std::string& output) -> std::atomic<double>& {
    const auto at = std::ranges::find(device.out_names, output) - device.out_names.begin();
    return levels.levels.at(static_cast<std::size_t>(at));
  };
  Guarded guarded{levels, unguarded(device)};
  guarded.disable_sensor_watch();
  auto stream = backend->open(request_for(device), guarded);
  REQUIRE(stream);
  REQUIRE((*stream)->start());
  const std::vector<std::pair<std::string, int>> waves{{"sine", FF_SINE},
                                                       {"triangle", FF_TRIANGLE},
                                                       {"sawtooth up", FF_SAW_UP},
                                                       {"sawtooth down", FF_SAW_DOWN}};
  for (const auto& [name, shape] : waves) {
    CAPTURE(name);
    const auto plays_as = [&](const auto& is) {
      return waits([&] {
        const auto effect = wheel.uploaded(FF_PERIODIC);
        return wheel.plays(FF_PERIODIC) && effect->u.periodic.waveform == shape && is(*effect);
      });
    };
    level(name + " period") = 0.025;
    level(name + " offset") = 0.25;
    level(name + " attack") = 0.1;
    level(name + " fade") = 0.15;
    level(name) = 0.5;
    CHECK(plays_as([](const ff_effect& effect) {
      return effect.u.periodic.period == 25 && effect.u.periodic.envelope.attack_length == 100;
    }));
    CHECK(plays_as([](const ff_effect& effect) {  // started again
      return effect.u.periodic.envelope.attack_length == 0 && effect.replay.length == 500;
    }));
    CHECK(wheel.uploaded(FF_PERIODIC)->u.periodic.magnitude == Approx(16384).margin(2));
    CHECK(wheel.uploaded(FF_PERIODIC)->u.periodic.offset == Approx(8192).margin(2));
    level(name) = 0.0;
    CHECK(plays_as([](const ff_effect& effect) {
      return effect.u.periodic.envelope.fade_length == 150 && effect.replay.length == 150;
    }));
    REQUIRE((*stream)->stop());
    CHECK(waits([&] { return !wheel.plays(FF_PERIODIC); }));
    stream->reset();
    for (auto& each : levels.levels) each = 0.0;
    stream = backend->open(request_for(device), guarded);
    REQUIRE(stream);
    REQUIRE((*stream)->start());
  }
  REQUIRE((*stream)->stop());
}

TEST_CASE("sdl: a wheel that is unplugged while it plays is lost, and comes back", "[.alsa]") {
  auto wheel = std::make_unique<Wheel>();
  const auto backend = sdl();
  const auto device = wheel_of(*backend);
  Levels levels;
  levels.levels[kForceX] = 0.5;
  Guarded guarded{levels, unguarded(device)};
  guarded.disable_sensor_watch();
  auto stream = ReconnectingStream::open(*backend, request_for(device), guarded);
  REQUIRE(stream);
  REQUIRE((*stream)->start());
  for (int turn = 0; turn < 3; ++turn) {
    REQUIRE(waits([&] { return wheel->plays(FF_CONSTANT); }));
    wheel.reset();
    REQUIRE(waits([&] { return (*stream)->tick(), (*stream)->state() == StreamState::Lost; }));
    wheel = std::make_unique<Wheel>();
    REQUIRE(waits([&] { return (*stream)->tick(), (*stream)->state() == StreamState::Running; }));
  }
  REQUIRE(waits([&] { return wheel->plays(FF_CONSTANT); }));
  REQUIRE((*stream)->stop());
}
