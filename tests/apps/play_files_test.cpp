#include "apps/play_files.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "engine/scene/measure.h"
#include "tests/engine/graph/temporary_folder.h"

using namespace tactus;
using namespace tactus::app;

namespace {

PlayedScene play(const char* scene, const char* duration) {
  SceneRun run;
  run.file = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments" / scene;
  run.duration = duration;
  run.show_progress = false;
  auto played = play_file(run);
  if (!played) throw std::runtime_error(to_string(played.error()));
  return std::move(*played);
}

/// The names of what is there, in order: "sound drives".
std::string kinds_of(const std::vector<std::string>& written) {
  std::string kinds;
  for (const auto& line : written) {
    const auto end = line.find(".wav  ");
    if (end == std::string::npos) continue;
    const auto begin = line.rfind('_', end) + 1;
    kinds += (kinds.empty() ? "" : " ") + line.substr(begin, end - begin);
  }
  return kinds;
}

}  // namespace

TEST_CASE("play files: the sound alone in one, the drives in another, as they are", "[apps]") {
  const test::TemporaryFolder folder;
  const auto played = play("cellomobo/scene.toml", "0.5 s");
  const PlayFiles files{folder.path().string(), {}};
  const auto written = write_files(files, played);
  REQUIRE(written);
  CHECK(kinds_of(*written) == "sound drives sensors motion");
  for (const auto& [file, signal] :
       {std::pair{"_sound.wav", "instrument.sound"}, std::pair{"_drives.wav", "instrument.shaker"}}) {
    const auto read = read_wav(base_of(files, played) + file);
    REQUIRE(read);
    REQUIRE(read->channels.size() == 1);
    const auto& samples = played.recording.find(signal)->samples;
    REQUIRE(read->channels[0].size() == samples.size());
    bool same = true;
    for (std::size_t n = 0; n < samples.size(); ++n)
      same = same && read->channels[0][n] == static_cast<double>(static_cast<float>(samples[n]));
    CHECK(same);
  }
}

TEST_CASE("play files: there is no file of what does not sound or is not driven", "[apps]") {
  const test::TemporaryFolder folder;
  const PlayFiles files{folder.path().string(), {}};
  const auto kinds = [&](const char* scene) {
    return kinds_of(write_files(files, play(scene, "0.2 s")).value());
  };
  CHECK(kinds("bouncing_ball/scene.toml") == "drives motion");
  CHECK(kinds("bouncing_ball/table_scene.toml") == "motion");
}

TEST_CASE("play files: a carrier for a sensor is not listened to", "[apps]") {
  const auto played = play("cellomobo/fingered.toml", "0.1 s");
  CHECK(played.recording.sounds == std::vector<std::string>{"sound"});
  CHECK(drive_names(played.recording) == std::vector<std::string>{"shaker", "tones"});
}
