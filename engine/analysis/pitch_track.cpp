#include "engine/analysis/pitch_track.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "engine/core/dimension.h"
#include "engine/core/median.h"
#include "engine/graph/node_type.h"

namespace tactus {
namespace {

constexpr double kHalfSemitone = 0.0293;  // 2^(1/24) - 1
constexpr double kShortest_s = 0.05;
constexpr double kSpoken_cents = 50;

bool jumps(double before, double now) {
  return std::max(before, now) > (1 + kHalfSemitone) * std::min(before, now);
}

/// Notes without what was heard.
std::vector<NoteHeard> wanted_notes(std::span<const double> wanted, Hertz rate) {
  std::vector<NoteHeard> notes;
  for (std::size_t from = 0, to = 0; from < wanted.size(); from = to) {
    to = from + 1;
    while (to < wanted.size() && !jumps(wanted[to - 1], wanted[to])) ++to;
    NoteHeard note;
    note.from_s = static_cast<double>(from) / rate.value;
    note.to_s = static_cast<double>(to) / rate.value;
    if (!(wanted[from] > 0) || note.to_s - note.from_s < kShortest_s) continue;
    const auto part = wanted.subspan(from, to - from);
    note.wanted_hz = median({part.begin(), part.end()});
    notes.push_back(note);
  }
  return notes;
}

/// The first moment from which on everything is near the end.
std::optional<double> speaks_after(const NoteHeard& note, const std::vector<PitchPoint>& points) {
  std::optional<double> since;
  for (const auto& point : points) {
    const bool near = std::abs(cents(point.hertz, note.heard_hz)) < kSpoken_cents;
    if (!near)
      since.reset();
    else if (!since)
      since = point.time_s - note.from_s;
  }
  return since;
}

void hear(NoteHeard& note, const std::vector<PitchPoint>& all) {
  std::vector<PitchPoint> points;
  std::copy_if(all.begin(), all.end(), std::back_inserter(points),
               [&](const auto& p) { return p.time_s >= note.from_s && p.time_s < note.to_s; });
  std::vector<double> late;
  for (const auto& point : points)
    if (point.time_s >= 0.5 * (note.from_s + note.to_s)) late.push_back(point.hertz);
  if (late.empty()) return;
  note.heard_hz = median(late);
  note.partial = static_cast<int>(std::lround(note.heard_hz / note.wanted_hz));
  note.cents = cents(note.heard_hz, note.wanted_hz * std::max(1, note.partial));
  const auto [low, high] = std::minmax_element(late.begin(), late.end());
  note.swing_cents = cents(*high, *low);
  note.speaks_after_s = speaks_after(note, points);
}

}  // namespace

std::vector<NoteHeard> notes_heard(const std::vector<PitchPoint>& track, std::span<const double> wanted_hz,
                                   Hertz rate) {
  auto notes = wanted_notes(wanted_hz, rate);
  for (auto& note : notes) hear(note, track);
  return notes;
}

std::optional<Melody> melody_of(const SceneRecording& recording) {
  static const auto kHertz = parse_unit("Hz")->dimension;
  const auto* sound = recording.find("instrument.sound");
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
  // From an octave below the lowest note to the third partial of the highest, or the sixth of the lowest.
  const double rate = recording.sample_rate.value;
  const Hertz lo{std::max(20.0, 0.45 * lowest)};
  const Hertz hi{std::min(0.1 * rate, std::max(3.3 * highest, 6.5 * lowest))};
  Melody melody{&*wanted, track_pitch(sound->samples, recording.sample_rate, lo, hi), {}};
  melody.notes = notes_heard(melody.heard, wanted->samples, recording.sample_rate);
  return melody;
}

std::string note_name(double hertz) {
  static constexpr std::array<const char*, 12> kNames = {"C",  "C#", "D",  "D#", "E",  "F",
                                                         "F#", "G",  "G#", "A",  "A#", "B"};
  const auto semitones = static_cast<int>(std::lround(57 + 12 * std::log2(hertz / 440)));  // from C0 on
  const int octave = semitones >= 0 ? semitones / 12 : -((11 - semitones) / 12);
  return kNames[static_cast<std::size_t>(semitones - 12 * octave)] + std::to_string(octave);
}

std::string in_words(const NoteHeard& note) {
  const auto name = fmt::format("{}, {:.1f} Hz: ", note_name(note.wanted_hz), note.wanted_hz);
  if (note.heard_hz <= 0) return name + "nothing with a pitch";
  auto text = name;
  if (note.partial != 1) text += fmt::format("{:.1f} Hz sounds, ", note.heard_hz);
  if (note.partial > 1) text += fmt::format("partial {}, ", note.partial);
  text += fmt::format("{:+.1f} cents", note.cents);
  if (note.swing_cents > 5) text += fmt::format(", swings by {:.0f}", note.swing_cents);
  if (note.speaks_after_s) text += fmt::format(", speaks after {:.2f} s", *note.speaks_after_s);
  return text;
}

std::string in_words(const std::vector<NoteHeard>& notes) {
  int right = 0;
  double off = 0, slowest = 0;
  for (const auto& note : notes) {
    if (note.partial != 1) continue;
    ++right;
    off = std::max(off, std::abs(note.cents));
    slowest = std::max(slowest, note.speaks_after_s.value_or(0));
  }
  auto text = fmt::format("{} of {} notes on their first partial", right, notes.size());
  if (right > 0) text += fmt::format(", at most {:.1f} cents off, within {:.2f} s", off, slowest);
  return text;
}

}  // namespace tactus
