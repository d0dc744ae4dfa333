#include "engine/scene/measures/notes/pitch_track.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "engine/core/dimension.h"
#include "engine/core/median.h"
#include "engine/graph/node_type.h"
#include "engine/scene/file/roles.h"
#include "engine/scene/measures/notes/standing_tone.h"

namespace tactus {
namespace {

constexpr double kElsewhere = 0.25;                  // of its time, in a right note
constexpr double kSlowest_hz = 3, kFastest_hz = 10;  // of a vibrato

/// What was heard at one moment of a note, and wanted.
struct Moment {
  PitchPoint heard;
  double wanted_hz;
};

std::vector<Moment> moments_of(const WantedNote& note, const std::vector<PitchPoint>& track,
                               std::span<const double> wanted, Hertz rate) {
  std::vector<Moment> moments;
  for (const auto& point : track)
    if (point.time_s >= note.from_s && point.time_s < note.to_s)
      moments.push_back({point, wanted[static_cast<std::size_t>(point.time_s * rate.value)]});
  return moments;
}

std::vector<Moment> from_time(const std::vector<Moment>& moments, double time_s) {
  std::vector<Moment> late;
  std::copy_if(moments.begin(), moments.end(), std::back_inserter(late),
               [&](const Moment& moment) { return moment.heard.time_s >= time_s; });
  return late;
}

double off_of(const Moment& moment) { return cents(moment.heard.hertz, moment.wanted_hz); }
double heard_of(const Moment& moment) { return moment.heard.hertz; }
double wanted_of(const Moment& moment) { return moment.wanted_hz; }
double level_of(const Moment& moment) { return moment.heard.rms; }

std::vector<double> each(const std::vector<Moment>& moments, double (*of)(const Moment&)) {
  std::vector<double> values;
  std::transform(moments.begin(), moments.end(), std::back_inserter(values), of);
  return values;
}

/// How often a pitch goes around its median: from the times at which it rises a quarter of its swing above
/// it after having been as far below. nullopt: fewer than three times, or not as often as a vibrato.
std::optional<double> vibrato_of(const std::vector<Moment>& moments) {
  const auto hertz = each(moments, heard_of);
  const double middle = median(hertz), far = 0.25 * swing_of(hertz);
  std::vector<double> rises;
  bool low = false;
  for (const auto& moment : moments) {
    const double off = cents(moment.heard.hertz, middle);
    if (off < -far) low = true;
    if (!low || off < far) continue;
    low = false;
    rises.push_back(moment.heard.time_s);
  }
  if (rises.size() < 3) return std::nullopt;
  const double often = static_cast<double>(rises.size() - 1) / (rises.back() - rises.front());
  return often >= kSlowest_hz && often <= kFastest_hz ? std::optional{often} : std::nullopt;
}

std::optional<double> speaks_after(const WantedNote& note, const std::vector<Moment>& moments, double off,
                                   double rms) {
  std::vector<ToneMoment> tone;
  for (const auto& moment : moments) tone.push_back({moment.heard.time_s, off_of(moment), moment.heard.rms});
  const auto stands_s = stands_at(tone, off, rms, std::min(kStands_s, 0.5 * note.seconds()));
  return stands_s ? std::optional{*stands_s - note.from_s} : std::nullopt;
}

/// What it did since it stands, or in its second half.
void tell_standing(NoteHeard& note, const std::vector<Moment>& moments) {
  const double stands_s = note.wanted.from_s + note.speaks_after_s.value_or(0.5 * note.wanted.seconds());
  const auto standing = from_time(moments, stands_s);
  note.swing_cents = swing_of(each(standing, heard_of));
  note.wanted_swing_cents = swing_of(each(standing, wanted_of));
  if (!note.wanted.glides) note.swings_hz = vibrato_of(standing);
  note.silent_s =
      std::max(0.0, note.wanted.to_s - stands_s - static_cast<double>(standing.size()) * kPitchHop_s);
}

/// Where it was when it was not where it should be.
void tell_strays(NoteHeard& note, const std::vector<Moment>& moments) {
  std::map<int, int> partials;
  int strays = 0;
  for (const auto& moment : moments) {
    const int partial = partial_of(moment.heard.hertz, moment.wanted_hz);
    if (partial > 1) ++partials[partial];
    if (partial == 0) ++strays;
  }
  note.strays_s = strays * kPitchHop_s;
  int most = 0;
  for (const auto& [partial, count] : partials) {
    note.partials_s += count * kPitchHop_s;
    if (count > most) note.other_partial = partial;
    most = std::max(most, count);
  }
}

NoteHeard hear(const WantedNote& wanted_note, const std::vector<PitchPoint>& track,
               std::span<const double> wanted, Hertz rate) {
  NoteHeard note;
  note.wanted = wanted_note;
  const auto moments = moments_of(wanted_note, track, wanted, rate);
  const auto late = from_time(moments, 0.5 * (wanted_note.from_s + wanted_note.to_s));
  if (late.empty()) return note;
  const double off = median(each(late, off_of));
  note.heard_hz = median(each(late, heard_of));
  note.partial = static_cast<int>(std::lround(std::exp2(off / 1200)));
  note.cents = off - cents(std::max(1, note.partial), 1);
  note.speaks_after_s = speaks_after(wanted_note, moments, off, median(each(late, level_of)));
  tell_standing(note, moments);
  tell_strays(note, moments);
  return note;
}

}  // namespace

bool NoteHeard::right() const {
  return partial == 1 && std::abs(cents) <= kInTune_cents &&
         partials_s + strays_s <= kElsewhere * wanted.seconds();
}

std::vector<NoteHeard> notes_heard(const std::vector<PitchPoint>& track, std::span<const double> wanted_hz,
                                   Hertz rate) {
  std::vector<NoteHeard> notes;
  for (const auto& wanted : wanted_notes(wanted_hz, rate))
    notes.push_back(hear(wanted, track, wanted_hz, rate));
  return notes;
}

Hertz lowest_tracked(Hertz lowest) { return Hertz{std::max(20.0, 0.45 * lowest.value)}; }

std::vector<PitchPoint> track_notes(std::span<const double> sound, Hertz rate, Hertz lowest, Hertz highest) {
  const double top = std::max(3.3 * highest.value, 6.5 * lowest.value);
  return track_pitch(sound, rate, lowest_tracked(lowest), Hertz{std::min(0.1 * rate.value, top)});
}

std::optional<Melody> melody_of(const SceneRecording& recording) {
  static const auto kHertz = parse_unit("Hz")->dimension;
  const auto* sound = recording.find(signal_of(recording.roles, "monitor"));
  const auto wanted =
      std::find_if(recording.signals.begin(), recording.signals.end(), [](const RecordedSignal& signal) {
        return signal.dimension == kHertz && !signal.name.starts_with("instrument.");
      });
  if (sound == nullptr || wanted == recording.signals.end()) return std::nullopt;
  double lowest = kUnlimited, highest = 0;
  for (const double hertz : wanted->samples) {
    if (hertz > 0) lowest = std::min(lowest, hertz);
    highest = std::max(highest, hertz);
  }
  if (!(highest > 0)) return std::nullopt;
  const auto rate = recording.sample_rate;
  Melody melody{&*wanted, track_notes(sound->samples, rate, Hertz{lowest}, Hertz{highest}), {}};
  melody.notes = notes_heard(melody.heard, wanted->samples, rate);
  return melody;
}

}  // namespace tactus
