#include "engine/scene/measures/notes/pitch_track.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/core/dimension.h"
#include "engine/core/median.h"
#include "engine/core/notes.h"
#include "engine/graph/node_type.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {
namespace {

constexpr double kOnsetLevel = 0.178;                // -15 dB
constexpr double kElsewhere = 0.25;                  // of its time, in a right note
constexpr double kSlowest_hz = 3, kFastest_hz = 10;  // of a vibrato

using Moments = std::vector<ToneMoment>;

Moments from_time(Moments moments, double time_s) {
  std::erase_if(moments, [=](const ToneMoment& moment) { return moment.time_s < time_s; });
  return moments;
}

/// How often a pitch goes around its median: from the times at which it rises a quarter of its swing above
/// it after having been as far below. nullopt: fewer than three times, or not as often as a vibrato.
std::optional<double> vibrato_of(const Moments& moments) {
  auto hertz = each(moments, &ToneMoment::hertz);
  const double far = 0.25 * swing_of(hertz), middle = median(std::move(hertz));
  std::vector<double> rises;
  bool low = false;
  for (const auto& moment : moments) {
    const double off = cents(moment.hertz, middle);
    if (off < -far) low = true;
    if (!low || off < far) continue;
    low = false;
    rises.push_back(moment.time_s);
  }
  if (rises.size() < 3) return std::nullopt;
  const double often = static_cast<double>(rises.size() - 1) / (rises.back() - rises.front());
  return often >= kSlowest_hz && often <= kFastest_hz ? std::optional{often} : std::nullopt;
}

std::optional<double> speaks_after(const ExpectedNote& note, const Moments& moments, double off, double rms) {
  const auto steady_from_s = steady_from(moments, off, rms, std::min(kSteady_s, 0.5 * note.seconds()));
  return steady_from_s ? std::optional{*steady_from_s - note.from_s} : std::nullopt;
}

/// Since it is steady, or in its second half.
void measure_steady(DetectedNote& note, const Moments& moments) {
  const double steady_from_s =
      note.expected.from_s + note.speaks_after_s.value_or(0.5 * note.expected.seconds());
  const auto steady = from_time(moments, steady_from_s);
  note.swing_cents = swing_of(each(steady, &ToneMoment::hertz));
  note.expected_swing_cents = swing_of(each(steady, &ToneMoment::expected_hz));
  if (!note.expected.glides) note.vibrato_hz = vibrato_of(steady);
  note.silent_s =
      std::max(0.0, note.expected.to_s - steady_from_s - static_cast<double>(steady.size()) * kPitchHop_s);
}

/// Time on other partials and on stray pitches.
void measure_strays(DetectedNote& note, const Moments& moments) {
  std::map<int, int> partials;
  int strays = 0;
  for (const auto& moment : moments) {
    const int partial = partial_of(moment.hertz, moment.expected_hz);
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

DetectedNote detect(const ExpectedNote& expected_note, const std::vector<PitchPoint>& track,
                    std::span<const double> expected, Hertz rate) {
  DetectedNote note;
  note.expected = expected_note;
  const auto moments = moments_between(track, expected_note.from_s, expected_note.to_s, [&](double time_s) {
    return expected[static_cast<std::size_t>(time_s * rate.value)];
  });
  const auto late = from_time(moments, 0.5 * (expected_note.from_s + expected_note.to_s));
  if (late.empty()) return note;
  const double off = median(each(late, &ToneMoment::off_cents));
  note.detected_hz = median(each(late, &ToneMoment::hertz));
  note.partial = static_cast<int>(std::lround(std::exp2(off / 1200)));
  note.cents = off - cents(std::max(1, note.partial), 1);
  note.speaks_after_s = speaks_after(expected_note, moments, off, median(each(late, &ToneMoment::rms)));
  measure_steady(note, moments);
  measure_strays(note, moments);
  return note;
}

// ---- expected notes

constexpr double kStep_cents = 5;      // a gesture that slides takes less than 1 from frame to frame
constexpr double kStill_cents = 0.05;  // from one moment to the next
constexpr double kGlide_cents = 50;
constexpr double kSwing_cents = 300, kSwing_s = 0.25;
constexpr double kShortestNote_s = 0.05, kShortestGlide_s = 0.1;

bool jumps(double before, double now) {
  return !(before > 0 && now > 0) || std::abs(cents(now, before)) > kStep_cents;
}

/// Moments between which a pitch rises, falls or stays.
struct Run {
  std::size_t from, to;
  double change = 0;  // [cents]; 0: it stays

  double seconds() const { return static_cast<double>(to - from) * kPitchHop_s; }
};

int sign_of(double change) { return std::abs(change) < kStill_cents ? 0 : change > 0 ? 1 : -1; }

std::vector<Run> runs_of(const std::vector<double>& pitch) {
  std::vector<Run> runs;
  int before = 0;
  for (std::size_t i = 0; i + 1 < pitch.size(); ++i) {
    const double change = cents(pitch[i + 1], pitch[i]);
    const int sign = sign_of(change);
    if (runs.empty() || sign != before) runs.push_back({i, i});
    before = sign;
    runs.back().to = i + 1;
    if (sign != 0) runs.back().change += change;
  }
  return runs;
}

bool swings_with(const Run& run, const Run& other) {
  const double size = std::abs(run.change);
  return run.change * other.change < 0 && std::abs(other.change) > 0.5 * size && size <= kSwing_cents &&
         run.seconds() <= kSwing_s;
}

bool is_glide(const std::vector<Run>& runs, std::size_t i) {
  if (std::abs(runs[i].change) <= kGlide_cents) return false;
  const auto neighbour = [&](std::ptrdiff_t step) -> const Run* {
    // A swing may rest for a moment where it turns around.
    for (auto n = static_cast<std::ptrdiff_t>(i) + step; n >= 0 && n < std::ssize(runs); n += step) {
      const auto& run = runs[static_cast<std::size_t>(n)];
      if (run.change != 0 || run.seconds() > kShortestNote_s) return &run;
    }
    return nullptr;
  };
  const auto *before = neighbour(-1), *after = neighbour(1);
  return !(before != nullptr && swings_with(runs[i], *before)) &&
         !(after != nullptr && swings_with(runs[i], *after));
}

ExpectedNote note_of(std::span<const double> expected, Hertz rate, std::size_t from, std::size_t to,
                     bool glides) {
  ExpectedNote note;
  note.from_s = static_cast<double>(from) / rate.value;
  note.to_s = static_cast<double>(to) / rate.value;
  const auto part = expected.subspan(from, to - from);
  note.begins_hz = part.front();
  note.ends_hz = part.back();
  note.hertz = median({part.begin(), part.end()});
  note.glides = glides;
  return note;
}

/// Frames without a jump: their notes and the glides between them.
void add_notes(std::vector<ExpectedNote>& notes, std::span<const double> expected, Hertz rate,
               std::size_t from, std::size_t to) {
  const auto hop = static_cast<std::size_t>(std::lround(kPitchHop_s * rate.value));
  std::vector<double> pitch;
  for (auto i = from; i < to; i += hop) pitch.push_back(expected[i]);
  const auto runs = runs_of(pitch);
  const auto add = [&](std::size_t first, std::size_t last, bool glides) {
    if (static_cast<double>(last - first) >= (glides ? kShortestGlide_s : kShortestNote_s) * rate.value)
      notes.push_back(note_of(expected, rate, first, last, glides));
  };
  auto begun = from;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!is_glide(runs, i)) continue;
    const auto first = from + runs[i].from * hop, last = std::min(to, from + runs[i].to * hop);
    add(begun, first, false);
    add(first, last, true);
    begun = last;
  }
  add(begun, to, false);
}

// ---- in words

constexpr double kAudible_cents = 5;  // just noticeable
constexpr double kReported_s = kSteady_s;

std::string head_of(const ExpectedNote& expected) {
  if (expected.glides)
    return fmt::format("from {} to {} in {:.2f} s, {:.1f} to {:.1f} Hz: ", pitch_text(expected.begins_hz),
                       pitch_text(expected.ends_hz), expected.seconds(), expected.begins_hz,
                       expected.ends_hz);
  return fmt::format("{}, {:.1f} Hz: ", pitch_text(expected.hertz), expected.hertz);
}

/// What sounds, where that is not the note.
std::string other_pitch_of(const DetectedNote& note) {
  if (note.partial == 1 && std::abs(note.cents) <= kNearPartial_cents) return {};
  auto text = fmt::format("{:.1f} Hz sounds, ", note.detected_hz);
  if (note.partial > 1 && std::abs(note.cents) <= kNearPartial_cents)
    return text + fmt::format("partial {}, ", note.partial);
  return text + pitch_text(note.detected_hz) + ", ";
}

std::string describe_swing(const DetectedNote& note) {
  if (note.expected.glides || note.swing_cents <= kAudible_cents) return {};
  if (!note.vibrato_hz) return fmt::format(", varies by {:.0f}", note.swing_cents);
  auto text = fmt::format(", vibrato of {:.0f} cents, {:.1f} per second", note.swing_cents, *note.vibrato_hz);
  if (note.expected_swing_cents > kAudible_cents)
    text += fmt::format(" ({:.0f} expected)", note.expected_swing_cents);
  return text;
}

std::string elsewhere_of(const DetectedNote& note) {
  std::string text;
  if (note.partials_s >= kReported_s)
    text += fmt::format(", on partial {} for {:.2f} s", note.other_partial, note.partials_s);
  if (note.strays_s >= kReported_s) text += fmt::format(", on other pitches for {:.2f} s", note.strays_s);
  if (note.silent_s >= kReported_s) text += fmt::format(", without a pitch for {:.2f} s", note.silent_s);
  return text;
}

}  // namespace

int partial_of(double hertz, double expected_hz) {
  const auto partial = static_cast<int>(std::lround(hertz / expected_hz));
  return partial >= 1 && std::abs(cents(hertz, partial * expected_hz)) <= kNearPartial_cents ? partial : 0;
}

std::vector<ToneMoment> moments_between(const std::vector<PitchPoint>& track, double from_s, double to_s,
                                        const std::function<double(double)>& expected) {
  std::vector<ToneMoment> moments;
  for (const auto& point : track)
    if (point.time_s >= from_s && point.time_s < to_s)
      moments.push_back({point.time_s, point.hertz, expected(point.time_s), point.rms});
  return moments;
}

std::optional<double> steady_from(const std::vector<ToneMoment>& moments, double off_cents, double rms,
                                  double hold_s) {
  const auto needed = static_cast<std::size_t>(std::max(1.0, std::round(hold_s / kPitchHop_s)));
  std::size_t run = 0;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    const bool steady = std::abs(moments[i].off_cents() - off_cents) <= kNearPartial_cents &&
                        moments[i].rms >= kOnsetLevel * rms;
    const bool follows = i == 0 || moments[i].time_s - moments[i - 1].time_s < 1.5 * kPitchHop_s;
    run = !steady ? 0 : follows ? run + 1 : 1;
    if (run == needed) return moments[i + 1 - needed].time_s;
  }
  return std::nullopt;
}

double swing_of(std::vector<double> hertz) {
  if (hertz.empty()) return 0;
  std::ranges::sort(hertz);
  const auto edge = hertz.size() / 20;
  return cents(hertz[hertz.size() - 1 - edge], hertz[edge]);
}

bool DetectedNote::right() const {
  return partial == 1 && std::abs(cents) <= kInTune_cents &&
         partials_s + strays_s <= kElsewhere * expected.seconds();
}

std::vector<DetectedNote> detect_notes(const std::vector<PitchPoint>& track,
                                       std::span<const double> expected_hz, Hertz rate) {
  std::vector<DetectedNote> notes;
  for (const auto& expected : expected_notes(expected_hz, rate))
    notes.push_back(detect(expected, track, expected_hz, rate));
  return notes;
}

Hertz lowest_tracked(Hertz lowest) { return Hertz{std::max(20.0, 0.45 * lowest.value)}; }

std::vector<PitchPoint> track_notes(std::span<const double> sound, Hertz rate, Hertz lowest, Hertz highest) {
  const double top = std::max(3.3 * highest.value, 6.5 * lowest.value);
  return track_pitch(sound, rate, lowest_tracked(lowest), Hertz{std::min(0.1 * rate.value, top)});
}

std::optional<Melody> melody_of(const SceneRecording& recording) {
  const auto* sound = recording.find(signal_of(recording.roles, "monitor"));
  const auto expected = std::ranges::find_if(recording.signals, [](const RecordedSignal& signal) {
    return is_frequency(signal.dimension) && !signal.name.starts_with("instrument.");
  });
  if (sound == nullptr || expected == recording.signals.end()) return std::nullopt;
  double lowest = kUnlimited, highest = 0;
  for (const double hertz : expected->samples) {
    if (hertz > 0) lowest = std::min(lowest, hertz);
    highest = std::max(highest, hertz);
  }
  if (!(highest > 0)) return std::nullopt;
  const auto rate = recording.sample_rate;
  Melody melody{&*expected, track_notes(sound->samples, rate, Hertz{lowest}, Hertz{highest}), {}};
  melody.notes = detect_notes(melody.detected, expected->samples, rate);
  return melody;
}

std::vector<ExpectedNote> expected_notes(std::span<const double> expected, Hertz rate) {
  std::vector<ExpectedNote> notes;
  for (std::size_t from = 0, to = 0; from < expected.size(); from = to) {
    to = from + 1;
    while (to < expected.size() && !jumps(expected[to - 1], expected[to])) ++to;
    if (expected[from] > 0) add_notes(notes, expected, rate, from, to);
  }
  return notes;
}

std::string pitch_text(double hertz) {
  const double over = cents(hertz, pitch_of_note(nearest_note(hertz)));
  return note_name(hertz) + (std::abs(over) < kAudible_cents ? "" : fmt::format(" {:+.0f} cents", over));
}

std::string describe(const DetectedNote& note) {
  auto text = head_of(note.expected);
  if (note.detected_hz <= 0) return text + "no pitched sound";
  if (!note.right()) text += "not right: ";
  text += other_pitch_of(note) + fmt::format("{:+.1f} cents", note.cents) + describe_swing(note);
  if (note.speaks_after_s && !note.expected.glides)
    text += fmt::format(", steady after {:.2f} s", *note.speaks_after_s);
  return text + elsewhere_of(note);
}

std::string describe(const std::vector<DetectedNote>& notes) {
  int right[2] = {0, 0}, all[2] = {0, 0};  // notes, glides
  double off = 0, slowest = 0;
  for (const auto& note : notes) {
    const int kind = note.expected.glides ? 1 : 0;
    ++all[kind];
    if (!note.right()) continue;
    ++right[kind];
    off = std::max(off, std::abs(note.cents));
    if (!note.expected.glides) slowest = std::max(slowest, note.speaks_after_s.value_or(0));
  }
  auto text = fmt::format("{} of {} notes right", right[0], all[0]);
  if (all[1] > 0) text += fmt::format(" and {} of {} glides", right[1], all[1]);
  if (right[0] + right[1] > 0)
    text += fmt::format(", at most {:.1f} cents off, each steady within {:.2f} s", off, slowest);
  return text;
}

}  // namespace tactus
