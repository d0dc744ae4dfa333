#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "apps/play/play_report.h"
#include "engine/scene/measures/measure.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace tactus::app;

namespace {

PlayedScene play(const char* scene, const char* duration) {
  PlayerOptions options;
  options.duration = duration;
  return play_file(resolve_target(std::string{TACTUS_SOURCE_DIR} + "/instruments/" + scene), options);
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
  const auto files = folder.path().string();
  const auto written = write_files(files, played, nullptr, shown_part({}, played));
  CHECK(kinds_of(written) == "sound drives sensors motion");
  // The sound with the scene's gain, as integers of 24 bits; the drives in single precision.
  const double gain = played.scene.monitor_gain;
  CHECK(gain == Approx(std::pow(10, 0.5)));
  for (const auto& [file, signal] :
       {std::pair{"_sound.wav", "instrument.sound"}, std::pair{"_drives.wav", "instrument.shaker"}}) {
    const auto read = read_wav(base_of(files, played) + file);
    REQUIRE(read);
    REQUIRE(read->channels.size() == 1);
    const auto& samples = played.recording.find(signal)->samples;
    REQUIRE(read->channels[0].size() == samples.size());
    const bool sound = file[1] == 's';
    bool same = true;
    for (std::size_t n = 0; n < samples.size(); ++n)
      same = same && (sound ? std::abs(read->channels[0][n] - gain * samples[n]) <= std::ldexp(1.0, -23)
                            : read->channels[0][n] == static_cast<double>(static_cast<float>(samples[n])));
    CHECK(same);
  }
}

TEST_CASE("play files: there is no file of what does not sound or is not driven", "[apps]") {
  const test::TemporaryFolder folder;
  const auto kinds = [&](const char* scene) {
    const auto played = play(scene, "0.2 s");
    return kinds_of(write_files(folder.path().string(), played, nullptr, shown_part({}, played)));
  };
  CHECK(kinds("bouncing_ball/scene.toml") == "drives motion");
  CHECK(kinds("bouncing_ball/table_scene.toml") == "motion");
}

TEST_CASE("play files: a carrier for a sensor is not listened to", "[apps]") {
  const auto played = play("cellomobo/fingered.toml", "0.1 s");
  CHECK(played.recording.sounds == std::vector<std::string>{"sound"});
  CHECK(drive_names(played.recording) == std::vector<std::string>{"shaker", "tones"});
}

namespace {

int render(const std::string& arguments) {
  const auto command = std::string{TACTUS_PROGRAM} + " render " + TACTUS_SOURCE_DIR + "/instruments/" +
                       arguments + " >/dev/null 2>&1";
  return std::system(command.c_str()) / 256;
}

}  // namespace

TEST_CASE("render: all outputs in one file, what is to be listened to in another", "[apps]") {
  const test::TemporaryFolder folder;
  const auto all = (folder.path() / "all.wav").string(), sound = (folder.path() / "sound.wav").string();
  REQUIRE(render("cellomobo --duration '0.5 s' --out " + all + " --sound " + sound) == 0);
  const auto both = read_wav(all), monitor = read_wav(sound);
  REQUIRE(both);
  REQUIRE(monitor);
  REQUIRE(both->channels.size() == 2);
  REQUIRE(monitor->channels.size() == 1);
  CHECK(monitor->channels[0] == both->channels[1]);
  CHECK(render("bouncing_ball --duration '0.1 s' --sound " + sound) == 2);
  CHECK(render("cellomobo --duration '0.1 s' --sound " + (folder.path() / "no" / "x.wav").string()) == 2);
}
