#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "engine/nodes/table.h"
#include "engine/scene/closed_loop.h"
#include "engine/scene/play_scene.h"
#include "tests/support/allocation_count.h"
#include "tests/support/graphs/node_runner.h"
#include "tests/support/optional_files.h"

using namespace tactus;
namespace fs = std::filesystem;

namespace {

const fs::path kInstruments = fs::path{TACTUS_SOURCE_DIR} / "instruments";

/// Every scene that is shipped: the files of the instruments' folders that have parts.
std::vector<fs::path> shipped_scenes() {
  std::vector<fs::path> scenes;
  for (const auto& entry : fs::recursive_directory_iterator{kInstruments}) {
    if (entry.path().extension() != ".toml" || test::is_left_out(entry.path())) continue;
    std::ifstream file{entry.path()};
    for (std::string line; std::getline(file, line);)
      if (line.starts_with("[parts]") || line.starts_with("[parts.")) {
        scenes.push_back(entry.path());
        break;
      }
  }
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

SceneSpec first_second(const fs::path& path) {
  auto scene = load_scene(path, kInstruments);
  if (!scene) throw std::runtime_error(to_string(scene.error()));
  scene->duration = std::min(scene->duration, Seconds{1});
  return std::move(*scene);
}

BuiltScene built(const SceneSpec& scene, std::optional<Seconds> delay) {
  auto result = build_scene(scene, standard_nodes(), {.delay = delay, .rate = {}, .set = {}});
  if (!result) throw std::runtime_error(to_string(result.error()));
  return std::move(*result);
}

SceneRecording recording_of(const SceneSpec& scene, std::optional<Seconds> delay, int block) {
  auto engines = built(scene, delay);
  auto recording = play_scene(scene, engines, block);
  if (!recording) throw std::runtime_error(to_string(recording.error()));
  return std::move(*recording);
}

test::Outputs samples(const SceneRecording& recording) {
  test::Outputs all;
  for (const auto& signal : recording.signals) all.push_back(signal.samples);
  return all;
}

}  // namespace

TEST_CASE("scenes: every shipped scene plays the same bits in blocks of any size, at any delay",
          "[scene][slow]") {
  const auto scenes = shipped_scenes();
  REQUIRE_FALSE(scenes.empty());
  for (const auto& path : scenes) {
    const auto scene = first_second(path);
    for (const auto delay :
         {std::optional<Seconds>{}, std::optional{0_ms}, std::optional{1_ms}, std::optional{10_ms}}) {
      const auto expected = recording_of(scene, delay, 1);
      INFO(path.string() << " at " << expected.delay_frames << " frames");
      CHECK(expected.faults.empty());
      CHECK(expected.bad_inputs == 0);
      double moved = 0;
      for (const auto& signal : expected.signals)
        for (const double sample : signal.samples) moved = std::max(moved, std::abs(sample));
      CHECK(moved > 0);
      for (const int block : {48, 64, 1000, 4096}) {
        INFO("blocks of " << block);
        CHECK(test::first_difference(samples(expected), samples(recording_of(scene, delay, block))) == "");
      }
    }
  }
}

TEST_CASE("scenes: the closed loop allocates nothing while it runs", "[scene]") {
  const auto scene = first_second(kInstruments / "haptic_drum" / "scene.toml");
  for (const auto delay : {0_ms, 20_ms}) {
    auto engines = built(scene, delay);
    Guarded guarded{*engines.instrument, guarded_channels(engines.instrument->plan(), scene.drives)};
    ClosedLoop loop{guarded, *engines.plant, engines.instrument->out_channels(), engines.delay_frames,
                    scene.converters};
    REQUIRE(loop.prepare(48_kHz, 64));
    const auto before = test::allocation_count();
    loop.run(24000);
    CHECK(test::allocation_count() == before);
  }
}
