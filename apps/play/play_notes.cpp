#include "apps/play/play_notes.h"

#include <fmt/format.h>

#include "engine/scene/measures/notes/format_note.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const ExpectedNote& wanted) {
  Json json{{"from_s", wanted.from_s},
            {"to_s", wanted.to_s},
            {"name", pitch_in_words(wanted.hertz)},
            {"wanted_hz", wanted.hertz}};
  if (wanted.glides) json["glides"] = {{"from_hz", wanted.begins_hz}, {"to_hz", wanted.ends_hz}};
  return json;
}

void add_notes(Json& json, const Melody& melody) {
  json["notes"] = Json::array();
  for (const auto& note : melody.notes) {
    auto entry = json_of(note.expected);
    entry.update(Json{{"right", note.right()},
                      {"heard_hz", note.detected_hz},
                      {"partial", note.partial},
                      {"cents", note.cents},
                      {"swing_cents", note.swing_cents},
                      {"on_other_partials_s", note.partials_s},
                      {"on_stray_pitches_s", note.strays_s},
                      {"without_pitch_s", note.silent_s},
                      {"words", in_words(note)}});
    if (note.vibrato_hz) entry["vibrato_hz"] = *note.vibrato_hz;
    if (note.speaks_after_s) entry["speaks_after_s"] = *note.speaks_after_s;
    json["notes"].push_back(std::move(entry));
  }
  json["notes_in_words"] = in_words(melody.notes);
}

void print_all(const std::string& title, const Json& heard) {
  fmt::print("  {:<19} {}\n", title, heard["notes_in_words"].get<std::string>());
  for (const auto& note : heard["notes"])
    fmt::print("    {:5.2f} s           {}\n", note["from_s"].get<double>(),
               note["words"].get<std::string>());
}

}  // namespace

void report_notes(Json& json, const PlayedScene& played, const PlayedScene* compared) {
  const auto melody = melody_of(played.recording);
  if (!melody) return;
  add_notes(json, *melody);
  const auto other = compared != nullptr ? melody_of(compared->recording) : std::nullopt;
  if (!other) return;
  auto& notes = json["compared_notes"] = {{"name", compared->scene.compare->name}};
  add_notes(notes, *other);
}

void print_notes(const Json& json) {
  if (!json.contains("notes")) return;
  print_all("heard", json);
  if (!json.contains("compared_notes")) return;
  const auto& other = json["compared_notes"];
  print_all(other["name"].get<std::string>(), other);
}

}  // namespace tactus::app
