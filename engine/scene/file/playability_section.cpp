#include "engine/graph/file/read_graph.h"
#include "engine/scene/file/roles.h"
#include "engine/scene/file/scene_fields.h"
#include "engine/scene/file/scene_sections.h"

namespace tactus {
namespace {

constexpr double kShortest_s = 1;  // of what is judged: a roll has a worst second

using Kind = Playability::Kind;

std::optional<Kind> read_kind(FieldReader& fields, const Source& section, ErrorList& mistakes) {
  if (!fields.has("kind"))
    mistakes.add(Errc::Missing, section, "[playability] lacks 'kind'",
                 "there are " + listed(playability_fields()["kind"].choices));
  const auto kind = fields.choice("kind");
  return kind ? std::optional{static_cast<Kind>(*kind)} : std::nullopt;
}

void read_times(FieldReader& fields, double end_s, Playability& judged, ErrorList& mistakes) {
  judged.from_s = fields.number("from", end_s).value_or(judged.from_s);
  judged.to_s = fields.number("to", end_s);
  if (judged.to_s.value_or(end_s) - judged.from_s >= kShortest_s) return;
  mistakes.add(Errc::OutOfRange, fields.at("from", judged.at), "less than a second is left to be judged",
               "lower 'from', or give more time behind it");
}

void read_signal(FieldReader& fields, const char* key, Playability::Signal& signal) {
  if (fields.has(key)) signal = {fields.text(key), fields.value(key)->at};
}

void read_roll(FieldReader& fields, Playability& judged) {
  read_signal(fields, "hits", judged.hits);
  read_signal(fields, "contact", judged.contact);
  judged.fewest = fields.number("fewest").value_or(judged.fewest);
}

/// "110 Hz", or "wanted.pitch": what a part gives out.
void read_pitch(FieldReader& fields, Playability& judged, ErrorList& mistakes) {
  if (!fields.has("pitch"))
    return mistakes.add(Errc::Missing, judged.at, "a tone needs the 'pitch' that is expected",
                        "give it as in pitch = \"110 Hz\", or as what a part gives out: \"wanted.pitch\"");
  const auto* text = fields.value("pitch")->text();
  if (text != nullptr && !text->empty() && text->front() >= 'a' && text->front() <= 'z')
    return read_signal(fields, "pitch", judged.pitch);
  judged.pitch_hz = fields.number("pitch").value_or(judged.pitch_hz);
}

void read_tone(FieldReader& fields, double end_s, Playability& judged, ErrorList& mistakes) {
  read_signal(fields, "sound", judged.sound);
  judged.begin_s = fields.number("begin", end_s).value_or(judged.begin_s);
  judged.quiet = fields.number("quiet").value_or(judged.quiet);
  read_pitch(fields, judged, mistakes);
  if (judged.begin_s > judged.from_s)
    mistakes.add(Errc::OutOfRange, fields.value("begin")->at,
                 "the tone begins after 'from', where it should be steady",
                 "raise 'from', which is 1 s if left out");
}

}  // namespace

std::optional<Playability> read_playability(const Value::Table& scene, Seconds duration,
                                            const std::vector<Role>& roles, ErrorList& mistakes) {
  const auto* section = read_section(scene, "playability", mistakes);
  if (section == nullptr) return std::nullopt;
  Playability judged;
  judged.at = find(scene, "playability")->at;
  judged.hits = {signal_of(roles, "hit"), judged.at};
  judged.contact = {signal_of(roles, "contact"), judged.at};
  judged.sound = {signal_of(roles, "monitor"), judged.at};
  FieldReader fields{*section, playability_fields(), mistakes};
  const auto kind = read_kind(fields, judged.at, mistakes);
  const double end_s = duration.value > 0 ? duration.value : kLongestTime_s;
  read_times(fields, end_s, judged, mistakes);
  if (!kind) return std::nullopt;
  judged.kind = *kind;
  if (*kind == Kind::Roll)
    read_roll(fields, judged);
  else
    read_tone(fields, end_s, judged, mistakes);
  return judged;
}

}  // namespace tactus
