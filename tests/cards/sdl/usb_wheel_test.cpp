// A wheel of the USB PID class behind the kernel's own driver, which gets reports of what the outputs play.
#include "tests/cards/sdl/usb_wheel.h"

#include <catch2/catch.hpp>
#include <memory>

#include "backends/reconnecting_stream.h"
#include "tests/cards/sdl/levels.h"

using namespace tactus;
using namespace tactus::test;

namespace {

const std::string kUsbWheel = std::string{"sdl:"} + UsbWheel::kName;
constexpr int kEffects = 8;                                        // seven, and one for both motors
constexpr int kSettings = static_cast<int>(kWaveSettings.size());  // of its sine
constexpr int kFromWest = 27000, kFromNorth = 0, kAnyDirection = -1;

struct Played {
  std::string output;
  int type, field;
  int direction;      ///< that a positive force comes from [0.01 degrees]
  double full_scale;  ///< what level 1 is in the wheel, relative to UsbWheel::kFullScale
  double level, changed;
};

/// A wheel has no motors: the kernel (drivers/input/ff-core.c) makes of both a sine of 20 Hz, of which the
/// slow one is two thirds and the fast one is one third.
const std::vector<Played> kPlayed{
    {"rumble low", kEtSine, kMagnitude, kAnyDirection, 2.0 / 3.0, 1.0, 0.6},
    {"rumble high", kEtSine, kMagnitude, kAnyDirection, 1.0 / 3.0, 0.5, 0.9},
    {"force x", kEtConstant, kMagnitude, kFromWest, 1.0, -0.5, 0.25},
    {"force y", kEtConstant, kMagnitude, kFromNorth, 1.0, 0.75, -1.0},
    {"sine", kEtSine, kMagnitude, kAnyDirection, 1.0, 0.3, 0.6},
    {"spring", kEtSpring, kPositiveCoefficient, kAnyDirection, 1.0, 0.75, 1.0},
    {"damper", kEtDamper, kNegativeCoefficient, kAnyDirection, 1.0, 0.2, 0.1},
    {"inertia", kEtInertia, kPositiveCoefficient, kAnyDirection, 1.0, 0.9, 0.05},
    {"friction", kEtFriction, kNegativeCoefficient, kAnyDirection, 1.0, 1.0, 0.5}};

/// Theory: SDL gets a level as the nearest 32767th, that is to half of 0.31 steps of the wheel; the kernel
/// rounds that to a whole step towards zero, and divides negative levels by 32768, which is 0.31 steps less.
constexpr double kRounding = 1.5;

struct OpenWheel {
  explicit OpenWheel(Backend& backend) : device(listed(backend, kUsbWheel, kEffects + 1 + kSettings)) {
    guarded.disable_sensor_watch();
    auto opened = backend.open(request_for(device), guarded);
    INFO((opened ? "" : to_string(opened.error())));
    REQUIRE(opened);
    stream = std::move(*opened);
    REQUIRE(stream->start());
  }
  std::atomic<double>& level(const std::string& output) {
    const auto at = std::ranges::find(device.out_names, output) - device.out_names.begin();
    return levels.levels.at(static_cast<std::size_t>(at));
  }
  /// But not the settings of the sine.
  void set_all(double level) { std::fill_n(levels.levels.begin(), kEffects + 1, level); }

  Device device;
  Levels levels;
  Guarded guarded{levels, unguarded(device)};
  std::unique_ptr<Stream> stream;
};

/// The effect of this type, as soon as it was started more than so many times.
UsbWheel::Effect started(const UsbWheel& wheel, int type, int starts) {
  UsbWheel::Effect effect;
  REQUIRE(waits([&] {
    const auto playing = wheel.playing(type);
    if (playing) effect = *playing;
    return playing && playing->starts > starts;
  }));
  return effect;
}

bool all_play(const UsbWheel& wheel, bool play) {
  const auto effects = wheel.effects();
  return std::ranges::all_of(effects, [&](const auto& effect) { return effect.plays == play; });
}

}  // namespace

TEST_CASE("sdl: a USB wheel gets what its outputs play, as reports of the PID class", "[.alsa]") {
  const UsbWheel wheel{kEffects};
  const auto backend = sdl();
  OpenWheel open{*backend};
  CHECK(open.device.in_names == std::vector<std::string>{"axis 0", "axis 1", "button 0", "button 1",
                                                         "button 2", "button 3", "button 4", "button 5",
                                                         "button 6", "button 7"});
  for (const auto& played : kPlayed) CHECK(std::ranges::count(open.device.out_names, played.output) == 1);
  CHECK(wheel.gain() == UsbWheel::kFullGain);
  for (const int position : {16384, -32767, 0}) {
    wheel.steer(position);
    CHECK(waits([&] { return std::abs(open.levels.input - position / 32767.0) < 1e-6; }));
  }
  for (const auto& played : kPlayed) {
    CAPTURE(played.output);
    const auto arrives = [&](double level) {
      const double expected = level * played.full_scale * UsbWheel::kFullScale;
      open.level(played.output) = level;
      return waits([&] {
        const auto effect = wheel.playing(played.type);
        return effect && std::abs(effect->fields.at(played.field) - expected) <= kRounding;
      });
    };
    REQUIRE(arrives(played.level));
    REQUIRE(arrives(played.changed));
    const auto effect = started(wheel, played.type, 0);
    CHECK(effect.fields.at(kDuration) == 500);  // a program that hangs pushes no longer
    CHECK(effect.fields.at(kGain) == UsbWheel::kFullGain);
    if (played.direction != kAnyDirection)
      CHECK(std::abs(effect.fields.at(kDirection) - played.direction) <= 1);
    if (played.field != kMagnitude) CHECK(effect.fields.at(kPositiveSaturation) == UsbWheel::kFullScale);
    const auto later = started(wheel, played.type, effect.starts + 1);  // started again, unchanged
    CHECK(later.changes == effect.changes);
    open.level(played.output) = 0.0;
    REQUIRE(waits([&] { return !wheel.playing(played.type); }));
  }
  open.set_all(0.5);
  REQUIRE(waits([&] { return wheel.effects().size() == kEffects && all_play(wheel, true); }));
  REQUIRE(open.stream->stop());
  CHECK(waits([&] { return all_play(wheel, false); }));
  CHECK(wheel.errors() == "");
}

TEST_CASE("sdl: the sine of a USB wheel has settings", "[.alsa]") {
  const UsbWheel wheel{kEffects};
  const auto backend = sdl();
  OpenWheel open{*backend};
  const auto plays_with = [&](int field, double value, double margin) {
    return waits([&] {
      const auto effect = wheel.playing(kEtSine);
      return effect && std::abs(effect->fields.at(field) - value) <= margin;
    });
  };
  open.level("sine period") = 0.025;
  open.level("sine offset") = 0.25;
  open.level("sine attack") = 0.1;
  open.level("sine fade") = 0.15;
  open.level("sine") = 0.5;
  CHECK(plays_with(kMagnitude, 0.5 * UsbWheel::kFullScale, kRounding));
  CHECK(plays_with(kPeriod, 25, 0));
  CHECK(plays_with(kOffset, 0.25 * UsbWheel::kFullScale, kRounding));
  CHECK(plays_with(kAttackTime, 0, 0));  // started again
  open.level("sine period") = 0.04;
  CHECK(plays_with(kPeriod, 40, 0));
  open.level("sine") = 0.0;
  CHECK(plays_with(kDuration, 150, 0));
  CHECK(plays_with(kFadeTime, 150, 0));
  REQUIRE(open.stream->stop());
  CHECK(waits([&] { return all_play(wheel, false); }));
  CHECK(wheel.errors() == "");
}

TEST_CASE("sdl: a USB wheel whose outputs all change in every block is not sent more than it takes",
          "[.alsa]") {
  const UsbWheel wheel{kEffects};
  const auto backend = sdl();
  OpenWheel open{*backend};
  open.set_all(0.5);
  REQUIRE(waits([&] { return wheel.effects().size() == kEffects && all_play(wheel, true); }));
  // Theory: all changes every 2 ms would be 13 reports each time, 2,600 altogether. The wheel takes 400
  // meanwhile, and the kernel drops what comes while 256 wait, also what stops an effect. A report every 2 ms
  // is 200.
  open.levels.changes = 400;
  REQUIRE(waits([&] { return open.levels.changes == 0; }));
  open.set_all(0.0);
  CHECK(waits([&] { return all_play(wheel, false); }));
  REQUIRE(open.stream->stop());
  CHECK(wheel.errors() == "");
}

TEST_CASE("sdl: an effect of a USB wheel plays on while devices are listed", "[.alsa]") {
  const UsbWheel wheel{kEffects};
  const auto backend = sdl();
  OpenWheel open{*backend};
  open.level("spring") = 0.5;
  const auto before = started(wheel, kEtSpring, 0);
  REQUIRE(backend->devices());
  const auto after = started(wheel, kEtSpring, before.starts + 1);
  CHECK(after.stops == 0);
}

TEST_CASE("sdl: a USB wheel that is unplugged while it plays is lost, and comes back", "[.alsa]") {
  UsbWheel wheel{kEffects};
  const auto backend = sdl();
  const auto device = listed(*backend, kUsbWheel, kEffects + 1 + kSettings);
  Levels levels;
  Guarded guarded{levels, unguarded(device)};
  guarded.disable_sensor_watch();
  auto stream = ReconnectingStream::open(*backend, request_for(device), guarded);
  REQUIRE(stream);
  REQUIRE((*stream)->start());
  std::fill_n(levels.levels.begin(), kEffects + 1, 0.5);
  // Its port and model, which stay the same whatever number the system gives it.
  const auto hardware = (*stream)->granted().output.hardware;
  CHECK(hardware.starts_with("usb-dummy_hcd"));
  CHECK((*stream)->granted().input.hardware == hardware);
  for (int turn = 0; turn < 3; ++turn) {
    CHECK((*stream)->granted().output.hardware == hardware);
    REQUIRE(waits([&] { return wheel.effects().size() == kEffects && all_play(wheel, true); }));
    wheel.unplug();
    REQUIRE(waits([&] { return (*stream)->tick(), (*stream)->state() == StreamState::Lost; }));
    wheel.plug();
    REQUIRE(waits([&] { return (*stream)->tick(), (*stream)->state() == StreamState::Running; }));
  }
  REQUIRE(waits([&] { return wheel.playing(kEtFriction).has_value(); }));
  REQUIRE((*stream)->stop());
  CHECK(wheel.errors() == "");
}

TEST_CASE("sdl: a USB wheel with four slots has four effects, both motors in one", "[.alsa]") {
  const UsbWheel wheel{4};
  const auto backend = sdl();
  const auto device = listed(*backend, kUsbWheel, 4 + 1 + kSettings);
  CHECK(device.out_names == std::vector<std::string>{"rumble low", "rumble high", "force x", "force y",
                                                     "sine", "sine period", "sine offset", "sine phase",
                                                     "sine attack", "sine fade"});
  Levels levels;
  Guarded guarded{levels, unguarded(device)};
  auto request = request_for(device);
  request.out_channels = 11;
  const auto refused = backend->open(request, guarded);
  REQUIRE_FALSE(refused);
  CHECK(to_string(refused.error()) ==
        "'" + kUsbWheel + "' has 10 outputs, but number 11 is requested; choose channels from 1 to 10");
}

TEST_CASE("sdl: effects that the memory of a USB wheel does not hold are reported, and the others play",
          "[.alsa]") {
  const UsbWheel wheel{kEffects, 4};
  const auto backend = sdl();
  OpenWheel open{*backend};
  open.set_all(0.5);
  std::string note;
  const std::string expected = kUsbWheel + " took not every effect: it has no slot left, or no such effect";
  CHECK(waits([&] { return (note = open.stream->take_note()) == expected; }));
  CHECK(waits([&] { return wheel.effects().size() == 4 && all_play(wheel, true); }));
  open.set_all(0.0);
  CHECK(waits([&] { return all_play(wheel, false); }));
  REQUIRE(open.stream->stop());
  CHECK(wheel.errors() == "");
}
