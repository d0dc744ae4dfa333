#include "apps/play/play_roll.h"

#include <fmt/format.h>

#include "engine/scene/file/roles.h"
#include "engine/scene/measures/measure.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

double asked(const char* what, const SceneRecording& recording) {
  Expectation all;
  all.measure = what;
  return measure(recording, all).value_or(0);
}

std::vector<double> hits_in(const SceneRecording& recording) {
  return triggers_of(recording, signal_of(recording.roles, "hit"));
}

Rhythm rhythm_in(const SceneRecording& recording) {
  return rhythm_of(hits_in(recording), 0, recording.seconds());
}

void add_compared(Json& json, const PlayedScene& compared) {
  const auto rhythm = rhythm_in(compared.recording);
  json["compared"] = {{"name", compared.scene.compare->name},
                      {"restitution", asked("restitution", compared.recording)},
                      {"hits", rhythm.count},
                      {"last_hit_s", rhythm.last_s}};
}

}  // namespace

void report_roll(Json& json, const PlayedScene& played, const PlayedScene* compared) {
  const auto& recording = played.recording;
  const auto* contact = recording.find(signal_of(recording.roles, "contact"));
  if (contact == nullptr) return;
  const auto rhythm = rhythm_in(recording);
  json["strikes"] = strikes_in(*contact, recording.sample_rate).size();
  json["hits"] = hits_in(recording).size();
  json["missed"] = asked("missed", recording);
  json["doubled"] = asked("doubled", recording);
  json["longest_detection_ms"] = 1e3 * asked("detection_time", recording);
  json["roll_rate_hz"] = rhythm.rate_hz;
  json["fewest_in_a_second"] = rhythm.fewest_in_a_second;
  json["spread"] = rhythm.spread;
  json["long_short"] = rhythm.long_short;
  json["growing_intervals"] = rhythm.growing;
  json["last_hit_s"] = rhythm.last_s;
  json["restitution"] = asked("restitution", recording);
  if (compared != nullptr) add_compared(json, *compared);
}

void print_roll(const Json& json) {
  if (!json.contains("strikes")) return;
  fmt::print(
      "  hits detected       {}, of {} strikes above 5 N {} missed; {} doubled; detected within {:.2f} ms\n",
      json["hits"].get<int>(), json["strikes"].get<int>(), json["missed"].get<double>(),
      json["doubled"].get<double>(), json["longest_detection_ms"].get<double>());
  fmt::print("  roll                {:.1f} hits a second, at least {} in any second, spread {:.0f} %\n",
             json["roll_rate_hz"].get<double>(), json["fewest_in_a_second"].get<int>(),
             100 * json["spread"].get<double>());
  fmt::print(
      "  intervals           long/short {:.2f}, longest run of growing ones {}, last hit at {:.2f} s\n",
      json["long_short"].get<double>(), json["growing_intervals"].get<int>(),
      json["last_hit_s"].get<double>());
  fmt::print("  restitution         {:.2f}", json["restitution"].get<double>());
  if (json.contains("compared")) {
    const auto& other = json["compared"];
    fmt::print("; {} {:.2f}, and {} hits, the last at {:.2f} s", other["name"].get<std::string>(),
               other["restitution"].get<double>(), other["hits"].get<int>(),
               other["last_hit_s"].get<double>());
  }
  fmt::print("\n");
}

}  // namespace tactus::app
