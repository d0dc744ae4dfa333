#include "engine/study/walls/wall_map.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <mutex>
#include <numbers>
#include <vector>

#include "engine/study/sweep/evaluate_runs.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;

namespace {

const std::filesystem::path kInstruments = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments";

WallStudy small_study() {
  WallStudy study;
  study.devices = {
      {"bare", {.mass = 0.05, .damping = 0.1, .friction = 0.2, .quantum = 0.15708e-3, .force_limit = 6.37}},
      {"held", {.mass = 0.06, .damping = 5.1}}};
  study.controllers = controllers_of_the_paper();
  study.points_per_decade = 2;
  return study;
}

}  // namespace

TEST_CASE("all_cores: each piece of work is done once, and the share done reaches 1", "[analysis]") {
  std::vector<std::atomic<int>> times(1000);
  std::mutex lock;
  double share = 0;
  parallel_for(
      1000, [&](int i) { ++times[static_cast<std::size_t>(i)]; },
      [&](double now) {
        const std::lock_guard guard{lock};
        CHECK(now >= share);
        share = now;
      });
  CHECK(std::all_of(times.begin(), times.end(), [](const auto& n) { return n == 1; }));
  CHECK(share == 1);
  parallel_for(
      0, [](int) { FAIL("there was nothing to do"); }, [](double) {});
}

TEST_CASE("wall_map: both sides of every border are as they should be", "[analysis]") {
  double share = 0;
  RunPlan plan;
  plan.progress = [&](double now) { share = now; };
  const auto map = *map_walls(small_study(), plan);
  // 3.3 decades of delay and 2.9 of rate, for two devices, and six controllers.
  CHECK(map.borders == 2 * (8 + 7 + 6));
  CHECK(map.confirmed == map.borders);
  CHECK(share == 1);
  for (const auto& curve : map.by_delay) {
    CHECK(curve.front().loop.delay.value == Approx(20e-6));
    CHECK(curve.back().loop.delay.value == Approx(40e-3));
    CHECK(std::is_sorted(curve.begin(), curve.end(),
                         [](const auto& a, const auto& b) { return a.stiffest > b.stiffest; }));
    for (const auto& limit : curve) CHECK(limit.passive <= limit.stiffest * (1 + 1e-9));
  }
  for (const auto& curve : map.by_rate) {
    CHECK(curve.front().loop.rate.value == Approx(250));
    CHECK(curve.back().loop.rate.value == Approx(192e3));
  }
  CHECK(map.friction_limit == Approx(2546.5).epsilon(1e-4));
}

TEST_CASE("wall_map: sixteen bits leave the microcontroller's wall where it is, six move it", "[analysis]") {
  auto study = small_study();
  study.controllers = {study.controllers.front()};
  const auto with_bits = [&](int bits) {
    study.controllers.front().bits = bits;
    return *map_walls(study)->controllers.front().fixed_point;
  };
  const auto fine = with_bits(16);
  CHECK(fine.force_step == Approx(6.37 / 32768));
  CHECK(fine.stiffness_step == Approx(6.37 / 32768 / 0.15708e-3));
  CHECK(fine.full_depth == Approx(6.37 / 1333).epsilon(0.01));
  // A start of a few counts sees the steps: 5 %. The bits round the stiffness to 1.24 N/m: 0.1 %.
  CHECK(fine.with_encoder == Approx(1333).epsilon(0.05));
  CHECK(fine.with_bits == Approx(fine.with_encoder).epsilon(0.002));
  const auto coarse = with_bits(6);  // 1267 N/m a step: one or none
  CHECK(std::abs(coarse.with_bits / coarse.with_encoder - 1) > 0.05);
}

TEST_CASE("wall_map: a device without damping carries no wall, and nothing is tried on it", "[analysis]") {
  auto study = small_study();
  study.devices = {{"bare", {.mass = 0.05, .damping = 0, .quantum = 0.15708e-3, .force_limit = 6.37}}};
  const auto map = *map_walls(study);
  CHECK(map.borders == 0);
  CHECK(map.by_delay.front().front().stiffest == 0);
  CHECK_FALSE(map.controllers.front().fixed_point);
}

TEST_CASE("wall_map: parts of a map make the whole of it, without computing any border twice", "[analysis]") {
  const test::TemporaryFolder folder;
  auto study = small_study();
  study.points_per_decade = 1;
  const auto whole = *map_walls(study);
  RunPlan plan;
  plan.cache = folder.path();
  plan.parts = 2;
  CHECK(map_walls(study, plan)->finished < whole.runs);
  plan.part = 1;
  CHECK(map_walls(study, plan)->finished == whole.runs);
  plan.stop = [] { return true; };
  const auto again = *map_walls(study, plan);
  CHECK(again.confirmed == whole.confirmed);
  for (std::size_t i = 0; i < whole.by_delay.front().size(); ++i)
    CHECK(again.by_delay.front()[i].stiffest == whole.by_delay.front()[i].stiffest);
}

TEST_CASE("wall_device: a scene says what its walls push, as its plant's controls are set", "[analysis]") {
  const auto scene = load_scene(kInstruments / "wall", kInstruments);
  REQUIRE(scene);
  const auto device = device_of(*scene);
  REQUIRE(device);
  CHECK(device->bare.mass == Approx(9e-3));
  CHECK(device->bare.damping == Approx(0.05));
  CHECK(device->bare.friction == Approx(0.2));
  CHECK(device->bare.quantum == Approx(2 * std::numbers::pi * 0.1 / 4000).epsilon(1e-4));
  CHECK(device->bare.force_limit == Approx(6.37));
  CHECK(device->held().mass == Approx(16e-3));
  CHECK(device->held().damping == Approx(2.05));
  const auto drum = load_scene(kInstruments / "haptic_drum", kInstruments);
  REQUIRE(drum);
  const auto none = device_of(*drum);
  REQUIRE_FALSE(none);
  CHECK(none.error().code == Errc::Missing);
  CHECK(none.error().what.find("'device_mass'") != std::string::npos);
}
