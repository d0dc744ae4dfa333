#include <catch2/catch.hpp>
#include <filesystem>

#include "apps/play/play_report.h"

using namespace tactus;
using namespace tactus::app;

namespace {

/// What is reported of a scene; null where no ball bounces.
nlohmann::ordered_json ball_of(const char* scene, const char* duration = "") {
  PlayerOptions options;
  options.duration = duration;
  const auto played =
      play_file(resolve_target(std::string{TACTUS_SOURCE_DIR} + "/instruments/" + scene), options);
  nlohmann::ordered_json json;
  for (const auto& section : sections_of(played, nullptr)) json.update(section.json);
  return json["ball"];
}

std::string words_of(const char* scene, const char* duration = "") {
  return ball_of(scene, duration)["words"].get<std::string>();
}

}  // namespace

TEST_CASE("play ball: the orbit of its landings", "[apps]") {
  CHECK(words_of("bouncing_ball/scene.toml") == "orbit of 1 landing in 1 period of the drive");
  CHECK(words_of("bouncing_ball/period_2.toml") == "orbit of 2 landings in 2 periods of the drive");
  CHECK(words_of("bouncing_ball/period_4.toml") == "orbit of 4 landings in 4 periods of the drive");
  CHECK(words_of("bouncing_ball/chaos.toml").starts_with("no periodic orbit of up to 8 landings; 0."));
  CHECK(words_of("bouncing_ball/table_scene.toml") == "orbit of 1 landing in 1 period of the drive");
}

TEST_CASE("play ball: a drum is none, and a moment says nothing", "[apps]") {
  CHECK(ball_of("haptic_drum/scene.toml", "0.2 s").is_null());
  CHECK(words_of("bouncing_ball/chaos.toml", "0.1 s").ends_with("too few to find the period of the orbit"));
}
