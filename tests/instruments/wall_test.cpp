#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/study/walls/wall_map.h"
#include "tests/support/shipped_scene.h"

using namespace tactus;
using test::play;
using test::shipped_scene;

namespace {

/// The stiffest spring that the arm of a scene carries, as it is held there.
double border_of(const SceneSpec& scene, std::optional<Seconds> delay = {}) {
  const auto device = device_of(scene);
  if (!device) throw std::runtime_error(to_string(device.error()));
  return wall_border(device->held(), {scene.rate, delay.value_or(scene.delay)}).stiffness;
}

double peak(const SceneRecording& recording, const char* signal, double from_s, double to_s) {
  const auto& samples = recording.find(signal)->samples;
  double most = 0;
  for (auto n = static_cast<std::size_t>(from_s * recording.sample_rate.value);
       n < static_cast<std::size_t>(to_s * recording.sample_rate.value); ++n)
    most = std::max(most, std::abs(samples[n]));
  return most;
}

bool howls(const SceneRecording& recording) {
  return std::any_of(recording.guard.events.begin(), recording.guard.events.end(),
                     [](const GuardEvent& event) { return event.kind == GuardEvent::Kind::Feedback; });
}

}  // namespace

TEST_CASE("wall: bare the arm carries less than the finger's wall, held far more", "[instruments]") {
  const auto scene = shipped_scene("wall");
  const auto device = device_of(scene);
  REQUIRE(device);
  const WallLoop loop{scene.rate, scene.delay};
  CHECK(wall_border(device->bare, loop).stiffness == Approx(667).epsilon(0.01));
  CHECK(border_of(scene) == Approx(27333).epsilon(0.01));
}

TEST_CASE("wall: the same wall turns active when its delay passes the border, and the watch says so",
          "[instruments]") {
  auto scene = shipped_scene("wall");
  const auto ports_at = [&](Seconds delay) {
    SceneOptions options;
    options.delay = delay;
    return play(scene, options).ports.front();
  };
  REQUIRE(border_of(scene, Seconds{0.2e-3}) > 2 * 2000);
  CHECK_FALSE(ports_at(Seconds{0.2e-3}).active_at_s);
  REQUIRE(border_of(scene, 5_ms) < 0.5 * 2000);
  const auto late = ports_at(5_ms);
  REQUIRE(late.active_at_s);
  CHECK(late.growth_w > 0.01);
}

TEST_CASE("exploding: four times too stiff, it grows until the drive guard ends it", "[instruments]") {
  auto scene = shipped_scene("exploding");
  scene.duration = 8_s;
  const double border = border_of(scene);
  CHECK(border == Approx(129.0).epsilon(0.001));  // b / tau = 102.4, times 1.26 for b tau / m = 2.56
  REQUIRE(500 > 3 * border);
  const auto recording = play(scene);
  // From 2 mm it swings wider with every turn; half a turn takes about 40 ms.
  CHECK(peak(recording, "plant.arm", 0.02, 0.1) > 2 * 2e-3);
  CHECK(peak(recording, "plant.motor", 0, 0.3) == Approx(6.37).epsilon(0.01));
  CHECK(peak(recording, "plant.motor", 0.25, 0.75) == 0);  // while its feedback is examined
  CHECK(howls(recording));
  REQUIRE(recording.ports.front().active_at_s);
  CHECK(*recording.ports.front().active_at_s < 0.1);
  CHECK(peak(recording, "plant.motor", 7, 8) == 0);
}

TEST_CASE("exploding: with a delay that it was made for, the same spring is calm", "[instruments]") {
  const auto scene = shipped_scene("exploding");
  SceneOptions options;
  options.delay = Seconds{0.1e-3};
  REQUIRE(border_of(scene, options.delay) > 10 * 500);
  const auto recording = play(scene, options);
  CHECK_FALSE(howls(recording));
  CHECK_FALSE(recording.ports.front().active_at_s);
}
