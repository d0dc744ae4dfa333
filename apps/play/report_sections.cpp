#include "apps/play/report_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/median.h"
#include "engine/dsp/pitch/pitch_detector.h"
#include "engine/scene/file/scene_spec.h"
#include "engine/scene/measures/landings.h"
#include "engine/scene/measures/measure.h"
#include "engine/scene/measures/notes/format_note.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;
using Section = std::unique_ptr<ReportSection>;

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
    return fmt::format("no periodic orbit of up to {} landings; {:.2f} landings a period of the drive",
                       kLongestOrbit, share);
  if (share <= 0) return fmt::format("orbit of {}", counted(bouncing.period, "landing"));
  return fmt::format("orbit of {} in {} of the drive", counted(bouncing.period, "landing"),
                     counted(std::round(100 * bouncing.period / share) / 100, "period"));
}

/// Landings at the end of a scene.
class BallSection : public ReportSection {
 public:
  static Section make(const PlayedScene& played, const PlayedScene*) {
    const auto& recording = played.recording;
    const auto *ball = playing(recording, "ball"), *table = playing(recording, "table");
    if (ball == nullptr || table == nullptr) return nullptr;
    auto section = std::make_unique<BallSection>();
    const double end = recording.seconds();
    section->bouncing_ =
        bouncing_in(ball->samples, table->samples, recording.sample_rate, std::max(0.0, end - kRead_s), end);
    section->drive_hz_ = driven_hz(recording, *table);
    return section;
  }

  void add_to(Json& json) const override {
    auto& ball = json["ball"] = {{"period_landings", bouncing_.period},
                                 {"landings_per_second", bouncing_.landings_per_second},
                                 {"drive_hz", drive_hz_},
                                 {"words", describe_orbit(bouncing_, drive_hz_)}};
    if (bouncing_.speeds.empty()) return;
    ball["slowest_m_per_s"] = slowest();
    ball["fastest_m_per_s"] = fastest();
  }

  std::string text() const override {
    auto text = fmt::format("  ball                {}\n", describe_orbit(bouncing_, drive_hz_));
    if (!bouncing_.speeds.empty())
      text += fmt::format("  landings            {:.1f} a second, at {:.3f} to {:.3f} m/s\n",
                          bouncing_.landings_per_second, slowest(), fastest());
    return text;
  }

 private:
  double slowest() const { return *std::min_element(bouncing_.speeds.begin(), bouncing_.speeds.end()); }
  double fastest() const { return *std::max_element(bouncing_.speeds.begin(), bouncing_.speeds.end()); }

  Bouncing bouncing_;
  double drive_hz_ = 0;
};

// ---- roll ----

double value_of(const char* name, const SceneRecording& recording) {
  Expectation all;
  all.measure = name;
  return measure(recording, all).value_or(0);
}

std::vector<double> hits_in(const SceneRecording& recording) {
  return triggers_of(recording, signal_of(recording.roles, "hit"));
}

Rhythm rhythm_in(const SceneRecording& recording) {
  return rhythm_of(hits_in(recording), 0, recording.seconds());
}

/// Strikes and the hits that were detected of them.
class RollSection : public ReportSection {
 public:
  static Section make(const PlayedScene& played, const PlayedScene* compared) {
    const auto& recording = played.recording;
    const auto* contact = playing(recording, "contact");
    if (contact == nullptr) return nullptr;
    auto section = std::make_unique<RollSection>();
    auto& roll = *section;
    roll.rhythm_ = rhythm_in(recording);
    roll.strikes_ = strikes_in(*contact, recording.sample_rate).size();
    roll.hits_ = hits_in(recording).size();
    roll.missed_ = value_of("missed", recording);
    roll.doubled_ = value_of("doubled", recording);
    roll.longest_detection_ms_ = 1e3 * value_of("detection_time", recording);
    roll.restitution_ = value_of("restitution", recording);
    if (compared != nullptr)
      roll.compared_ = Compared{compared->scene.compare->name, value_of("restitution", compared->recording),
                                rhythm_in(compared->recording)};
    return section;
  }

  void add_to(Json& json) const override {
    json.update(Json{{"strikes", strikes_},
                     {"hits", hits_},
                     {"missed", missed_},
                     {"doubled", doubled_},
                     {"longest_detection_ms", longest_detection_ms_},
                     {"roll_rate_hz", rhythm_.rate_hz},
                     {"fewest_in_a_second", rhythm_.fewest_in_a_second},
                     {"spread", rhythm_.spread},
                     {"long_short", rhythm_.long_short},
                     {"growing_intervals", rhythm_.growing},
                     {"last_hit_s", rhythm_.last_s},
                     {"restitution", restitution_}});
    if (compared_)
      json["compared"] = {{"name", compared_->name},
                          {"restitution", compared_->restitution},
                          {"hits", compared_->rhythm.count},
                          {"last_hit_s", compared_->rhythm.last_s}};
  }

  std::string text() const override {
    auto text = fmt::format(
        "  hits detected       {}, of {} strikes above 5 N {} missed; {} doubled; detected within {:.2f} ms\n"
        "  roll                {:.1f} hits a second, at least {} in any second, spread {:.0f} %\n"
        "  intervals           long/short {:.2f}, longest run of growing ones {}, last hit at {:.2f} s\n"
        "  restitution         {:.2f}",
        hits_, strikes_, missed_, doubled_, longest_detection_ms_, rhythm_.rate_hz,
        rhythm_.fewest_in_a_second, 100 * rhythm_.spread, rhythm_.long_short, rhythm_.growing, rhythm_.last_s,
        restitution_);
    if (compared_)
      text += fmt::format("; {} {:.2f}, and {} hits, the last at {:.2f} s", compared_->name,
                          compared_->restitution, compared_->rhythm.count, compared_->rhythm.last_s);
    return text + "\n";
  }

 private:
  struct Compared {
    std::string name;
    double restitution;
    Rhythm rhythm;
  };
  Rhythm rhythm_;
  std::size_t strikes_ = 0, hits_ = 0;
  double missed_ = 0, doubled_ = 0, longest_detection_ms_ = 0, restitution_ = 0;
  std::optional<Compared> compared_;
};

// ---- notes ----

Json json_of(const DetectedNote& note) {
  const auto& expected = note.expected;
  Json json{{"from_s", expected.from_s},
            {"to_s", expected.to_s},
            {"name", pitch_in_words(expected.hertz)},
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
                   {"words", in_words(note)}});
  if (note.vibrato_hz) json["vibrato_hz"] = *note.vibrato_hz;
  if (note.speaks_after_s) json["speaks_after_s"] = *note.speaks_after_s;
  return json;
}

using Notes = std::vector<DetectedNote>;

void add_notes(Json& json, const Notes& notes) {
  json["notes"] = Json::array();
  for (const auto& note : notes) json["notes"].push_back(json_of(note));
  json["notes_in_words"] = in_words(notes);
}

std::string text_of(const std::string& title, const Notes& notes) {
  auto text = fmt::format("  {:<19} {}\n", title, in_words(notes));
  for (const auto& note : notes)
    text += fmt::format("    {:5.2f} s           {}\n", note.expected.from_s, in_words(note));
  return text;
}

/// Expected and detected notes.
class NotesSection : public ReportSection {
 public:
  static Section make(const PlayedScene& played, const PlayedScene* compared) {
    const auto melody = melody_of(played.recording);
    if (!melody) return nullptr;
    auto section = std::make_unique<NotesSection>();
    section->notes_ = melody->notes;
    const auto other = compared != nullptr ? melody_of(compared->recording) : std::nullopt;
    if (other) section->compared_ = std::pair{compared->scene.compare->name, other->notes};
    return section;
  }

  void add_to(Json& json) const override {
    add_notes(json, notes_);
    if (!compared_) return;
    auto& notes = json["compared_notes"] = {{"name", compared_->first}};
    add_notes(notes, compared_->second);
  }

  std::string text() const override {
    return text_of("detected", notes_) + (compared_ ? text_of(compared_->first, compared_->second) : "");
  }

 private:
  Notes notes_;
  std::optional<std::pair<std::string, Notes>> compared_;
};

struct RoleSection {
  const char* role;
  Section (*make)(const PlayedScene&, const PlayedScene*);
};
constexpr RoleSection kSections[] = {
    {"ball", BallSection::make}, {"contact", RollSection::make}, {"monitor", NotesSection::make}};

}  // namespace

std::vector<std::unique_ptr<ReportSection>> sections_of(const PlayedScene& played,
                                                        const PlayedScene* compared) {
  const auto& roles = played.scene.roles;
  const bool asks = std::any_of(roles.begin(), roles.end(), [](const Role& role) { return role.written; });
  std::vector<Section> sections;
  for (const auto& role : roles)
    for (const auto& known : kSections)
      if (role.name == known.role && role.written == asks)
        if (auto section = known.make(played, compared)) sections.push_back(std::move(section));
  return sections;
}

}  // namespace tactus::app
