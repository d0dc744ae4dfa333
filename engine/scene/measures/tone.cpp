#include "engine/scene/measures/tone.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "engine/core/decibels.h"
#include "engine/core/median.h"
#include "engine/scene/measures/notes/pitch_track.h"
#include "engine/scene/measures/notes/steady_tone.h"
#include "engine/scene/measures/roll.h"

namespace tactus {
namespace {

constexpr double kRightShare = 0.9;      // of a right note
constexpr double kShortestTone_s = 0.2;  // of a note that can be judged

/// An expected note.
struct Expected {
  double from_s, to_s;                  ///< begins, ends
  double steady_s;                      ///< from here on it should be steady
  double until_s;                       ///< and up to here no window reaches into the next
  double hertz;                         ///< median
  std::span<const double> moving = {};  ///< pitch of each frame of the scene; empty: it does not move
  double rate = 0;

  double hertz_at(double time_s) const {
    const auto frame = static_cast<std::size_t>(time_s * rate);
    return frame < moving.size() && moving[frame] > 0 ? moving[frame] : hertz;
  }
};

std::span<const double> between(const RecordedSignal& signal, Hertz rate, double from, double to) {
  const auto frame = [&](double time) {
    return std::min(signal.samples.size(), static_cast<std::size_t>(time * rate.value));
  };
  return std::span{signal.samples}.subspan(frame(from), frame(to) - frame(from));
}

/// The moments of the part that should be steady.
struct Moments {
  double frames = 0;  ///< that there are, with a pitch or without
  double right = 0, partials = 0;
  std::vector<double> hertz, off_cents, level;

  double right_share() const { return right / frames; }
  double strays() const { return frames - right - partials; }
};

Moments moments_of(const std::vector<PitchPoint>& track, const Expected& note) {
  Moments moments;
  moments.frames = std::max(1.0, std::floor((note.until_s - note.steady_s) / kPitchHop_s));
  for (const auto& point : track) {
    if (point.time_s < note.steady_s || point.time_s >= note.until_s) continue;
    const double expected = note.hertz_at(point.time_s);
    moments.hertz.push_back(point.hertz);
    moments.off_cents.push_back(cents(point.hertz, expected));
    moments.level.push_back(point.rms);
    const int partial = partial_of(point.hertz, expected);
    if (partial == 1 && std::abs(moments.off_cents.back()) <= kInTune_cents) ++moments.right;
    if (partial > 1) ++moments.partials;
  }
  moments.right = std::min(moments.right, moments.frames);
  return moments;
}

/// Standard deviation around the straight line through the values, over their mean: a swell is steady.
double spread_of(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  double sum = 0, leaning = 0, lever = 0, squares = 0;
  for (const double x : values) sum += x;
  const double mean = values.empty() ? 0 : sum / count;
  if (mean <= 0) return 1;
  const auto place = [&](std::size_t i) { return static_cast<double>(i) - 0.5 * (count - 1); };
  for (std::size_t i = 0; i < values.size(); ++i) {
    leaning += place(i) * (values[i] - mean);
    lever += place(i) * place(i);
  }
  const double slope = lever > 0 ? leaning / lever : 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double off = values[i] - mean - slope * place(i);
    squares += off * off;
  }
  return std::sqrt(squares / count) / mean;
}

/// The first moment of the note from which on it is steady; its end if there is none.
double steady_in(const std::vector<PitchPoint>& track, const Moments& moments, const Expected& note) {
  if (moments.hertz.empty()) return note.to_s;
  std::vector<ToneMoment> all;
  for (const auto& point : track)
    if (point.time_s >= note.from_s && point.time_s < note.to_s)
      all.push_back({point.time_s, cents(point.hertz, note.hertz_at(point.time_s)), point.rms});
  return steady_from(all, median(moments.off_cents), median(moments.level)).value_or(note.to_s);
}

const char* kind_of(double level, double quiet, const Moments& moments) {
  if (level < quiet) return "silent";
  if (moments.right_share() >= kRightShare) return "right note";
  return moments.partials > moments.strays() ? "wrong partial" : "howl";
}

JudgedTone judge_note(std::span<const double> steady, const std::vector<PitchPoint>& track,
                      const Expected& note, double quiet) {
  JudgedTone judged;
  auto& [run, values] = judged;
  const auto moments = moments_of(track, note);
  const double pitch = median(moments.hertz);
  values.start_s = steady_in(track, moments, note) - note.from_s;
  values.partial = pitch > 0 ? partial_of(pitch, note.hertz) : 0;
  values.cents = pitch > 0 ? cents(pitch, std::max(1, values.partial) * note.hertz) : 0;
  values.right = moments.right_share();
  values.level_spread = spread_of(moments.level);
  values.swing_cents = swing_of(moments.hertz);
  values.level = rms_of(steady);
  run.kind = kind_of(values.level, quiet, moments);
  if (run.kind != "silent")
    run.score = values.right * kPrompt_s / std::max(values.start_s, kPrompt_s) * kSteadySpread /
                std::max(values.level_spread, kSteadySpread);
  run.playable = run.kind == "right note" && run.score >= kLeastScore;
  return judged;
}

/// Half of what the tracker looks at around a moment: three periods of the lowest pitch.
double reach_s(double lowest_hz) { return 1.5 / lowest_tracked(Hertz{lowest_hz}).value; }

Expected held_note(const SceneRecording& recording, const Playability& judged) {
  const double end = judged.to_s.value_or(recording.seconds());
  return {judged.begin_s, end, judged.from_s, std::min(end, recording.seconds() - 10 / judged.pitch_hz),
          judged.pitch_hz};
}

/// Those that sound between `begin` and `to`. Each has as long to settle as the first, at most half its time.
std::vector<Expected> notes_of(const SceneRecording& recording, const Playability& judged) {
  if (judged.pitch.name.empty()) return {held_note(recording, judged)};
  const auto* expected = recording.find(judged.pitch.name);
  if (expected == nullptr) return {};
  const double end = judged.to_s.value_or(recording.seconds());
  std::vector<Expected> notes;
  double lowest = kUnlimited;
  for (const auto& note : expected_notes(expected->samples, recording.sample_rate)) {
    const double from = std::max(judged.begin_s, note.from_s), to = std::min(end, note.to_s);
    if (to - from < kShortestTone_s) continue;
    const double settles = std::min(judged.from_s - judged.begin_s, 0.5 * (to - from));
    notes.push_back(
        {from, to, from + settles, to, note.hertz, expected->samples, recording.sample_rate.value});
    lowest = std::min(lowest, note.hertz);
  }
  // No moment counts whose window reaches into the next note, or beyond the end.
  for (auto& note : notes) {
    const bool last = &note == &notes.back();
    const double edge = last ? recording.seconds() - 10 / note.hertz : note.to_s - reach_s(lowest);
    note.until_s = std::max(note.steady_s, std::min(note.to_s, edge));
  }
  return notes;
}

/// All notes as one run.
JudgedTone together(const std::vector<JudgedTone>& notes) {
  const auto worse = [](const JudgedTone& a, const JudgedTone& b) {
    return a.run.playable != b.run.playable ? !a.run.playable : a.run.score < b.run.score;
  };
  auto all = *std::min_element(notes.begin(), notes.end(), worse);
  double score = 0;
  for (const auto& note : notes) {
    score += note.run.score;
    all.values.good_notes += note.run.playable ? 1 : 0;
  }
  all.values.notes = static_cast<int>(notes.size());
  all.run.score = score / static_cast<double>(notes.size());
  return all;
}

}  // namespace

const std::vector<RunKind>& tone_kinds() {
  static const std::vector<RunKind> kinds = {
      {"right note", 'N', "in tune within 25 cents in 9 of 10 moments"},
      {"wrong partial", 'p', "mostly another partial of the note"},
      {"howl", 'h', "another pitch, or none"},
      {"silent", '.', "softer than 'quiet'"},
  };
  return kinds;
}

JudgedTone tone_of(const SceneRecording& recording, const Playability& judged) {
  const auto* sound = recording.find(judged.sound.name);
  const auto notes = notes_of(recording, judged);
  Window window{recording, judged.from_s, judged.to_s};
  JudgedTone tone{{"silent", 0, false, {}}, {}};
  if (sound != nullptr && !notes.empty()) {
    const auto [low, high] = std::minmax_element(
        notes.begin(), notes.end(), [](const Expected& a, const Expected& b) { return a.hertz < b.hertz; });
    const auto rate = recording.sample_rate;
    // The tracker leaves out both ends of what it is given.
    auto track = track_notes(between(*sound, rate, judged.begin_s, recording.seconds()), rate,
                             Hertz{low->hertz}, Hertz{high->hertz});
    for (auto& point : track) point.time_s += judged.begin_s;
    std::vector<JudgedTone> tones;
    for (const auto& note : notes)
      tones.push_back(judge_note(between(*sound, rate, note.steady_s, note.to_s), track, note, judged.quiet));
    tone = together(tones);
  }
  window.tone = &tone.values;
  tone.run.readings = column_values(Playability::Kind::Tone, window);
  return tone;
}

}  // namespace tactus
