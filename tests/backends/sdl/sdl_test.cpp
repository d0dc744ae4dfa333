// The backend for joysticks and gamepads, on a gamepad that SDL simulates. On devices of a real kernel:
// tests/cards/sdl.
#include <SDL.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>

#include "backends/backend.h"
#include "backends/reconnecting_stream.h"
#include "engine/core/named.h"
#include "tests/support/wait_until.h"

using namespace tactus;
using namespace std::chrono_literals;
using test::wait_until;

namespace {

/// The guard lets everything through.
const std::vector<GuardedChannel> kFree(2, {DriveGuard::Kind::Audio, {.ceiling = 1.0}, {false, false}});

std::unique_ptr<Backend> sdl() { return find_named(haptic_backends(), "sdl")->make(); }

/// Two axes, two buttons and two motors.
class Gamepad {
 public:
  Gamepad() {
    REQUIRE(SDL_InitSubSystem(SDL_INIT_JOYSTICK | SDL_INIT_GAMECONTROLLER) == 0);
    SDL_VirtualJoystickDesc description{};
    description.version = SDL_VIRTUAL_JOYSTICK_DESC_VERSION;
    description.type = SDL_JOYSTICK_TYPE_GAMECONTROLLER;
    description.naxes = description.nbuttons = 2;
    description.name = "Simulated Gamepad";
    description.userdata = this;
    description.Rumble = [](void* self, Uint16 slow, Uint16 fast) {
      static_cast<Gamepad*>(self)->low = slow;
      static_cast<Gamepad*>(self)->high = fast;
      return 0;
    };
    number_ = SDL_JoystickAttachVirtualEx(&description);
    REQUIRE(number_ >= 0);
    joystick_ = SDL_JoystickOpen(number_);
    REQUIRE(joystick_ != nullptr);
  }
  ~Gamepad() {
    SDL_JoystickClose(joystick_);
    SDL_JoystickDetachVirtual(number_);
    SDL_QuitSubSystem(SDL_INIT_JOYSTICK | SDL_INIT_GAMECONTROLLER);
  }
  void move(int axis, Sint16 value) { REQUIRE(SDL_JoystickSetVirtualAxis(joystick_, axis, value) == 0); }
  void press(int button, bool down) {
    REQUIRE(SDL_JoystickSetVirtualButton(joystick_, button, down ? 1 : 0) == 0);
  }

  std::atomic<int> low{0}, high{0};

 private:
  int number_ = -1;
  SDL_Joystick* joystick_ = nullptr;
};

/// The first axis drives the first motor, the first button the second one.
class Copy final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat& granted) override {
    format = granted;
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    std::copy_n(io.in[0], io.frames, io.out[0]);
    std::copy_n(io.in[2], io.frames, io.out[1]);
    frames += io.frames;
  }
  StreamFormat format;
  std::atomic<std::int64_t> frames{0};
};

StreamRequest request() {
  StreamRequest request;
  request.device = "sdl:Simulated Gamepad";
  request.in_channels = 4;
  request.out_channels = 2;
  return request;
}

bool near(int strength, double level) { return std::abs(strength - 65535 * level) < 100; }

}  // namespace

TEST_CASE("sdl: a gamepad is a device with named channels, and no default") {
  const Gamepad gamepad;
  const auto devices = sdl()->devices();
  REQUIRE(devices);
  const auto found = std::ranges::find(*devices, "sdl:Simulated Gamepad", &Device::id);
  REQUIRE(found != devices->end());
  CHECK(found->in_names == std::vector<std::string>{"axis 0", "axis 1", "button 0", "button 1"});
  CHECK(found->out_names == std::vector<std::string>{"rumble low", "rumble high"});
  CHECK(found->default_rate == 8_kHz);
  CHECK_FALSE(found->is_default);
}

TEST_CASE("sdl: axes and buttons are inputs, motors are outputs, and stopping stops them") {
  Gamepad gamepad;
  const auto backend = sdl();
  Copy copy;
  Guarded guarded{copy, kFree};
  guarded.disable_sensor_watch();
  auto opened = backend->open(request(), guarded);
  REQUIRE(opened);
  auto& stream = **opened;
  CHECK(stream.granted().block_frames == 8);
  CHECK(stream.granted().input_latency_frames == 8.0);
  REQUIRE(stream.start());
  gamepad.move(0, 16384);
  CHECK(wait_until([&] { return near(gamepad.low, 0.5); }));
  gamepad.press(0, true);
  CHECK(wait_until([&] { return near(gamepad.high, 1.0); }));
  gamepad.press(0, false);
  CHECK(wait_until([&] { return gamepad.high == 0; }));
  CHECK(near(gamepad.low, 0.5));
  const auto frames = copy.frames.load();
  CHECK(wait_until([&] { return copy.frames > frames + 800; }));
  REQUIRE(stream.stop());
  CHECK(gamepad.low == 0);
}

TEST_CASE("sdl: a gamepad that is unplugged is lost, and comes back") {
  auto gamepad = std::make_unique<Gamepad>();
  const auto backend = sdl();
  Copy copy;
  Guarded guarded{copy, kFree};
  guarded.disable_sensor_watch();
  auto stream = ReconnectingStream::open(*backend, request(), guarded);
  REQUIRE(stream);
  REQUIRE((*stream)->start());
  const auto until = [&](StreamState state) {
    return wait_until([&] {
      (*stream)->tick();
      return (*stream)->state() == state;
    });
  };
  CHECK(until(StreamState::Running));
  gamepad.reset();
  CHECK(until(StreamState::Lost));
  gamepad = std::make_unique<Gamepad>();
  CHECK(until(StreamState::Running));
  gamepad->move(0, 32767);
  CHECK(wait_until([&] { return near(gamepad->low, 1.0); }));
}

TEST_CASE("sdl: a rate that is no multiple of 1 kHz, and a device that is not there, are refused") {
  const Gamepad gamepad;
  Copy copy;
  Guarded guarded{copy, kFree};
  guarded.disable_sensor_watch();
  auto wanted = request();
  wanted.sample_rate = 44.1_kHz;
  const auto odd = sdl()->open(wanted, guarded);
  REQUIRE_FALSE(odd);
  CHECK(odd.error().code == Errc::BadArgument);
  wanted = request();
  wanted.device = "sdl:Telegraph";
  const auto missing = sdl()->open(wanted, guarded);
  REQUIRE_FALSE(missing);
  CHECK(missing.error().code == Errc::UnknownName);
}
