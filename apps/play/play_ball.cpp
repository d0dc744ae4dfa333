#include "apps/play/play_ball.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/median.h"
#include "engine/dsp/pitch/pitch_detector.h"
#include "engine/scene/file/roles.h"
#include "engine/scene/measures/landings.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kRead_s = 2.0;  // at the end of a scene

/// How often the table is driven, 0 if it stands. The ball shakes a light table, and not what drives it.
double driven_hz(const SceneRecording& recording, const std::string& table) {
  const auto* drive =
      recording.find(recording.outputs.empty() ? table : "instrument." + recording.outputs.front());
  std::vector<double> found;
  const auto last =
      std::min(drive->samples.size(), static_cast<std::size_t>(kRead_s * recording.sample_rate.value));
  for (const auto& point :
       track_pitch(std::span{drive->samples}.last(last), recording.sample_rate, 8_Hz, 100_Hz))
    found.push_back(point.hertz);
  return median(std::move(found));
}

std::string counted(double number, const std::string& what) {
  return fmt::format("{:.4g} {}{}", number, what, std::abs(number - 1) < 1e-3 ? "" : "s");
}

std::string in_words(const Bouncing& bouncing, double drive_hz) {
  if (bouncing.speeds.empty()) return "no landing";
  if (bouncing.period == 0 && bouncing.speeds.size() <= 2 * kLongestOrbit)
    return fmt::format("{}: too few to say when it does the same again",
                       counted(static_cast<double>(bouncing.speeds.size()), "landing"));
  const double share = drive_hz > 0 ? bouncing.landings_per_second / drive_hz : 0;
  if (bouncing.period == 0)
    return fmt::format(
        "never the same again: no orbit of up to {} landings; {:.2f} landings a period of the drive",
        kLongestOrbit, share);
  if (share <= 0) return fmt::format("the same again after {}", counted(bouncing.period, "landing"));
  return fmt::format("{} in {} of the drive, then the same again", counted(bouncing.period, "landing"),
                     counted(std::round(100 * bouncing.period / share) / 100, "period"));
}

}  // namespace

void report_ball(Json& json, const PlayedScene& played, const PlayedScene*) {
  const auto& recording = played.recording;
  const double end = recording.seconds();
  const auto table_name = signal_of(recording.roles, "table");
  const auto *position = recording.find(signal_of(recording.roles, "ball")),
             *table = recording.find(table_name);
  if (position == nullptr || table == nullptr) return;
  const auto bouncing = bouncing_in(position->samples, table->samples, recording.sample_rate,
                                    std::max(0.0, end - kRead_s), end);
  const double drive = driven_hz(recording, table_name);
  auto& ball = json["ball"] = {{"period_landings", bouncing.period},
                               {"landings_per_second", bouncing.landings_per_second},
                               {"drive_hz", drive},
                               {"words", in_words(bouncing, drive)}};
  if (bouncing.speeds.empty()) return;
  const auto [slowest, fastest] = std::minmax_element(bouncing.speeds.begin(), bouncing.speeds.end());
  ball["slowest_m_per_s"] = *slowest;
  ball["fastest_m_per_s"] = *fastest;
}

void print_ball(const Json& json) {
  if (!json.contains("ball")) return;
  const auto& ball = json["ball"];
  fmt::print("  ball                {}\n", ball["words"].get<std::string>());
  if (!ball.contains("slowest_m_per_s")) return;
  fmt::print("  landings            {:.1f} a second, at {:.3f} to {:.3f} m/s\n",
             ball["landings_per_second"].get<double>(), ball["slowest_m_per_s"].get<double>(),
             ball["fastest_m_per_s"].get<double>());
}

}  // namespace tactus::app
