#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "apps/play/play_report.h"
#include "engine/core/median.h"
#include "engine/dsp/pitch/pitch_detector.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/scene/measures/measure.h"
#include "engine/scene/measures/motion.h"
#include "engine/scene/measures/notes/pitch_track.h"

namespace tactus::app {
namespace {

const RecordedSignal* playing(const SceneRecording& recording, const char* role) {
  return recording.find(signal_of(recording.roles, role));
}

// ---- ball ----

constexpr double kRead_s = 2.0;  // at the end of a scene

/// The frequency of the drive, 0 if it rests. The ball shakes a light table, and not what drives it.
double driven_hz(const SceneRecording& recording, const RecordedSignal& table) {
  const auto* drive =
      recording.outputs.empty() ? &table : recording.find("instrument." + recording.outputs.front());
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

std::string describe_orbit(const Bouncing& bouncing, double drive_hz) {
  if (bouncing.speeds.empty()) return "no landing";
  if (bouncing.period == 0 && bouncing.speeds.size() <= 2 * kLongestOrbit)
    return fmt::format("{}: too few to find the period of the orbit",
                       counted(static_cast<double>(bouncing.speeds.size()), "landing"));
  const double share = drive_hz > 0 ? bouncing.landings_per_second / drive_hz : 0;
  if (bouncing.period == 0)
    return fmt::format("no periodic orbit of up to {} landings; {:.2f} landings per drive period",
                       kLongestOrbit, share);
  if (share <= 0) return fmt::format("orbit of {}", counted(bouncing.period, "landing"));
  return fmt::format("orbit of {} in {} of the drive", counted(bouncing.period, "landing"),
                     counted(std::round(100 * bouncing.period / share) / 100, "period"));
}

/// Landings at the end of a scene.
ReportSection ball_section(const PlayedScene& played, const PlayedScene*) {
  const auto& recording = played.recording;
  const auto *ball = playing(recording, "ball"), *table = playing(recording, "table");
  if (ball == nullptr || table == nullptr) return {};
  const double end = recording.seconds();
  const auto bouncing =
      bouncing_in(ball->samples, table->samples, recording.sample_rate, std::max(0.0, end - kRead_s), end);
  const double drive_hz = driven_hz(recording, *table);
  const auto orbit = describe_orbit(bouncing, drive_hz);
  ReportSection section;
  auto& json = section.json["ball"] = {{"period_landings", bouncing.period},
                                       {"landings_per_second", bouncing.landings_per_second},
                                       {"drive_hz", drive_hz},
                                       {"words", orbit}};
  section.text = fmt::format("  ball                {}\n", orbit);
  if (bouncing.speeds.empty()) return section;
  const auto [slowest, fastest] = std::minmax_element(bouncing.speeds.begin(), bouncing.speeds.end());
  json["slowest_m_per_s"] = *slowest;
  json["fastest_m_per_s"] = *fastest;
  section.text += fmt::format("  landings            {:.1f} per second, at {:.3f} to {:.3f} m/s\n",
                              bouncing.landings_per_second, *slowest, *fastest);
  return section;
}

// ---- roll ----

double value_of(const char* name, const SceneRecording& recording) {
  Expectation all;
  all.measure = name;
  return measure(recording, all).value_or(0);
}

std::vector<double> hits_in(const SceneRecording& recording) {
  return triggers_of(recording, signal_of(recording.roles, "hit"));
}

/// From where on a scene judges its roll; 0 where it does not, or is played for a shorter time.
double judged_from_s(const PlayedScene& played) {
  const auto& judged = played.scene.playability;
  if (!judged || judged->kind != Playability::Kind::Roll) return 0;
  return judged->from_s < played.recording.seconds() ? judged->from_s : 0;
}

/// Strikes and the hits that were detected of them.
ReportSection roll_section(const PlayedScene& played, const PlayedScene* compared) {
  const auto& recording = played.recording;
  const auto* contact = playing(recording, "contact");
  if (contact == nullptr) return {};
  const auto hits = hits_in(recording);
  const double from_s = judged_from_s(played), last_s = hits.empty() ? 0 : hits.back();
  const auto rhythm = rhythm_of(hits, from_s, recording.seconds());
  const auto strikes = strikes_in(*contact, recording.sample_rate).size();
  const double missed = value_of("missed", recording), doubled = value_of("doubled", recording);
  const double longest_detection_ms = 1e3 * value_of("detection_time", recording);
  const double restitution = value_of("restitution", recording);
  ReportSection roll{
      {{"strikes", strikes},
       {"hits", hits.size()},
       {"missed", missed},
       {"doubled", doubled},
       {"longest_detection_ms", longest_detection_ms},
       {"roll_from_s", from_s},
       {"roll_rate_hz", rhythm.rate_hz},
       {"fewest_in_a_second", rhythm.fewest_in_a_second},
       {"spread", rhythm.spread},
       {"long_short", rhythm.long_short},
       {"growing_intervals", rhythm.growing},
       {"last_hit_s", last_s},
       {"restitution", restitution}},
      fmt::format(
          "  hits detected       {}, of {} strikes above 5 N {} missed; {} doubled; detected within {:.2f} "
          "ms\n"
          "  roll                {:.1f} hits per second, at least {} in any second, spread {:.1f} %{}\n"
          "  intervals           long/short {:.2f}, longest run of increasing intervals {}, last hit at "
          "{:.2f} s\n"
          "  restitution         {:.2f}",
          hits.size(), strikes, missed, doubled, longest_detection_ms, rhythm.rate_hz,
          rhythm.fewest_in_a_second, 100 * rhythm.spread,
          from_s > 0 ? fmt::format(", from {:g} s on", from_s) : "", rhythm.long_short, rhythm.growing,
          last_s, restitution)};
  if (compared != nullptr) {
    const auto& name = compared->scene.compare->name;
    const auto other = rhythm_of(hits_in(compared->recording), 0, compared->recording.seconds());
    const double rebound = value_of("restitution", compared->recording);
    roll.json["compared"] = {
        {"name", name}, {"restitution", rebound}, {"hits", other.count}, {"last_hit_s", other.last_s}};
    roll.text += fmt::format("; {} {:.2f}, and {} hits, the last at {:.2f} s", name, rebound, other.count,
                             other.last_s);
  }
  roll.text += "\n";
  return roll;
}

// ---- notes ----

Json note_json(const DetectedNote& note) {
  const auto& expected = note.expected;
  Json json{{"from_s", expected.from_s},
            {"to_s", expected.to_s},
            {"name", pitch_text(expected.hertz)},
            {"wanted_hz", expected.hertz}};
  if (expected.glides) json["glides"] = {{"from_hz", expected.begins_hz}, {"to_hz", expected.ends_hz}};
  json.update(Json{{"right", note.right()},
                   {"heard_hz", note.detected_hz},
                   {"partial", note.partial},
                   {"cents", note.cents},
                   {"swing_cents", note.swing_cents},
                   {"on_other_partials_s", note.partials_s},
                   {"on_stray_pitches_s", note.strays_s},
                   {"without_pitch_s", note.silent_s},
                   {"words", describe(note)}});
  if (note.vibrato_hz) json["vibrato_hz"] = *note.vibrato_hz;
  if (note.speaks_after_s) json["speaks_after_s"] = *note.speaks_after_s;
  return json;
}

/// The detected notes of a recording under a title.
ReportSection notes_of(const std::string& title, const std::vector<DetectedNote>& notes) {
  ReportSection section{{{"notes", list_of(notes, note_json)}, {"notes_in_words", describe(notes)}},
                        fmt::format("  {:<19} {}\n", title, describe(notes))};
  for (const auto& note : notes)
    section.text += fmt::format("    {:5.2f} s           {}\n", note.expected.from_s, describe(note));
  return section;
}

ReportSection notes_section(const PlayedScene& played, const PlayedScene* compared) {
  const auto melody = melody_of(played.recording);
  if (!melody) return {};
  auto section = notes_of("detected", melody->notes);
  const auto other = compared != nullptr ? melody_of(compared->recording) : std::nullopt;
  if (!other) return section;
  const auto& name = compared->scene.compare->name;
  const auto compared_notes = notes_of(name, other->notes);
  auto& json = section.json["compared_notes"] = {{"name", name}};
  json.update(compared_notes.json);
  section.text += compared_notes.text;
  return section;
}

struct RoleSection {
  const char* role;
  ReportSection (*make)(const PlayedScene&, const PlayedScene*);
};
constexpr RoleSection kSections[] = {
    {"ball", ball_section}, {"contact", roll_section}, {"monitor", notes_section}};

}  // namespace

std::vector<ReportSection> sections_of(const PlayedScene& played, const PlayedScene* compared) {
  const auto& roles = played.scene.roles;
  const bool asks = std::any_of(roles.begin(), roles.end(), [](const Role& role) { return role.written; });
  std::vector<ReportSection> sections;
  for (const auto& role : roles)
    for (const auto& known : kSections)
      if (role.name == known.role && role.written == asks) sections.push_back(known.make(played, compared));
  return sections;
}

}  // namespace tactus::app
