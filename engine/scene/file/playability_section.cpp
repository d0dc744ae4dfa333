#include "engine/scene/file/playability_section.h"

#include <algorithm>

#include "engine/graph/file/nearest.h"
#include "engine/graph/file/read_graph.h"
#include "engine/scene/file/roles.h"
#include "engine/scene/file/scene_sections.h"

namespace tactus {
namespace {

constexpr double kLongest_s = 86400;
constexpr double kShortest_s = 1;  // of what is judged: a roll has a worst second

using Kind = Playability::Kind;

std::optional<Kind> read_kind(const Value::Table& fields, const Source& section, Mistakes& mistakes) {
  const auto* value = find(fields, "kind");
  if (value == nullptr) {
    mistakes.add(Errc::Missing, section, "[playability] lacks 'kind'",
                 "there are " + listed(playability_kinds()));
    return std::nullopt;
  }
  const auto word = mistakes.text(fields, "kind");
  const auto& kinds = playability_kinds();
  const auto found = std::find(kinds.begin(), kinds.end(), word);
  if (found != kinds.end()) return static_cast<Kind>(found - kinds.begin());
  const auto near = nearest_name(word, kinds);
  if (value->text() != nullptr)
    mistakes.add(Errc::UnknownName, value->at, "nothing of kind '" + word + "' can be judged",
                 near.empty() ? "there are " + listed(kinds) : "did you mean '" + near + "'?");
  return std::nullopt;
}

/// Keys of the other kind are told apart from slips of the pen.
void check_keys(const Value::Table& fields, std::optional<Kind> kind, Mistakes& mistakes) {
  static const std::vector<std::string> kBoth = {"kind", "from", "to", "about"};
  static const std::vector<std::string> kRoll = {"hits", "contact", "fewest"};
  static const std::vector<std::string> kTone = {"sound", "pitch", "begin", "quiet"};
  auto known = kBoth;
  if (!kind || *kind == Kind::Roll) known.insert(known.end(), kRoll.begin(), kRoll.end());
  if (!kind || *kind == Kind::Tone) known.insert(known.end(), kTone.begin(), kTone.end());
  mistakes.unknown_keys(fields, known);
}

void read_times(const Value::Table& fields, double end_s, Playability& judged, Mistakes& mistakes) {
  judged.from_s = read_bounded(fields, "from", "s", 0, end_s, mistakes).value_or(judged.from_s);
  judged.to_s = read_bounded(fields, "to", "s", 0, end_s, mistakes);
  if (judged.to_s.value_or(end_s) - judged.from_s >= kShortest_s) return;
  const auto* from = find(fields, "from");
  mistakes.add(Errc::OutOfRange, from != nullptr ? from->at : judged.at,
               "less than a second is left to be judged", "lower 'from', or give more time behind it");
}

void read_signal(const Value::Table& fields, const char* key, Playability::Signal& signal,
                 Mistakes& mistakes) {
  const auto* value = find(fields, key);
  if (value == nullptr) return;
  signal = {mistakes.text(fields, key), value->at};
}

void read_roll(const Value::Table& fields, Playability& judged, Mistakes& mistakes) {
  read_signal(fields, "hits", judged.hits, mistakes);
  read_signal(fields, "contact", judged.contact, mistakes);
  judged.fewest = read_whole(fields, "fewest", 1, 100, mistakes).value_or(judged.fewest);
}

/// "110 Hz", or "wanted.pitch": what a part gives out.
void read_pitch(const Value::Table& fields, Playability& judged, Mistakes& mistakes) {
  const auto* value = find(fields, "pitch");
  if (value == nullptr)
    return mistakes.add(Errc::Missing, judged.at, "a tone needs the 'pitch' that is wanted",
                        "give it as in pitch = \"110 Hz\", or as what a part gives out: \"wanted.pitch\"");
  const auto* text = value->text();
  if (text != nullptr && !text->empty() && text->front() >= 'a' && text->front() <= 'z')
    return read_signal(fields, "pitch", judged.pitch, mistakes);
  judged.pitch_hz = read_bounded(fields, "pitch", "Hz", 1, 20e3, mistakes).value_or(judged.pitch_hz);
}

void read_tone(const Value::Table& fields, double end_s, Playability& judged, Mistakes& mistakes) {
  read_signal(fields, "sound", judged.sound, mistakes);
  judged.begin_s = read_bounded(fields, "begin", "s", 0, end_s, mistakes).value_or(judged.begin_s);
  judged.quiet = read_bounded(fields, "quiet", "", 1e-9, 1, mistakes).value_or(judged.quiet);
  read_pitch(fields, judged, mistakes);
  if (judged.begin_s > judged.from_s)
    mistakes.add(Errc::OutOfRange, find(fields, "begin")->at,
                 "the tone begins after 'from', where it should be steady",
                 "raise 'from', which is 1 s if left out");
}

}  // namespace

const std::vector<std::string>& playability_kinds() {
  static const std::vector<std::string> kinds = {"roll", "tone"};  // in the order of Playability::Kind
  return kinds;
}

std::optional<Playability> read_playability(const Value::Table& scene, Seconds duration,
                                            const std::vector<Role>& roles, Mistakes& mistakes) {
  const auto* fields = read_section(scene, "playability", mistakes);
  if (fields == nullptr) return std::nullopt;
  Playability judged;
  judged.at = find(scene, "playability")->at;
  judged.hits = {signal_of(roles, "hit"), judged.at};
  judged.contact = {signal_of(roles, "contact"), judged.at};
  judged.sound = {signal_of(roles, "monitor"), judged.at};
  const auto kind = read_kind(*fields, judged.at, mistakes);
  check_keys(*fields, kind, mistakes);
  mistakes.text(*fields, "about");
  const double end_s = duration.value > 0 ? duration.value : kLongest_s;
  read_times(*fields, end_s, judged, mistakes);
  if (!kind) return std::nullopt;
  judged.kind = *kind;
  if (*kind == Kind::Roll)
    read_roll(*fields, judged, mistakes);
  else
    read_tone(*fields, end_s, judged, mistakes);
  return judged;
}

}  // namespace tactus
