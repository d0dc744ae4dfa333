#include "engine/study/playability/judged_tone.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "engine/core/median.h"
#include "engine/study/notes/pitch_track.h"
#include "engine/study/notes/standing_tone.h"
#include "engine/study/playability/judged_roll.h"

namespace tactus {
namespace {

constexpr double kRightShare = 0.9;      // of a right note
constexpr double kShortestTone_s = 0.2;  // of a note that can be judged

/// A note that is wanted, and what is known of it.
struct Wanted {
  double from_s, to_s;                  ///< begins, ends
  double steady_s;                      ///< from here on it should stand
  double until_s;                       ///< and up to here no window reaches into the next
  double hertz;                         ///< median
  std::span<const double> moving = {};  ///< pitch of each frame of the scene; empty: it does not move
  double rate = 0;

  double hertz_at(double time_s) const {
    const auto frame = static_cast<std::size_t>(time_s * rate);
    return frame < moving.size() && moving[frame] > 0 ? moving[frame] : hertz;
  }
};

double rms_of(std::span<const double> samples) {
  double squares = 0;
  for (const double x : samples) squares += x * x;
  return samples.empty() ? 0 : std::sqrt(squares / static_cast<double>(samples.size()));
}

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

Moments moments_of(const std::vector<PitchPoint>& track, const Wanted& note) {
  Moments moments;
  moments.frames = std::max(1.0, std::floor((note.until_s - note.steady_s) / kPitchHop_s));
  for (const auto& point : track) {
    if (point.time_s < note.steady_s || point.time_s >= note.until_s) continue;
    const double wanted = note.hertz_at(point.time_s);
    moments.hertz.push_back(point.hertz);
    moments.off_cents.push_back(cents(point.hertz, wanted));
    moments.level.push_back(point.rms);
    const int partial = partial_of(point.hertz, wanted);
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

/// The first moment of the note from which on it stands; its end if there is none.
double stands_in(const std::vector<PitchPoint>& track, const Moments& moments, const Wanted& note) {
  if (moments.hertz.empty()) return note.to_s;
  std::vector<ToneMoment> all;
  for (const auto& point : track)
    if (point.time_s >= note.from_s && point.time_s < note.to_s)
      all.push_back({point.time_s, cents(point.hertz, note.hertz_at(point.time_s)), point.rms});
  return stands_at(all, median(moments.off_cents), median(moments.level)).value_or(note.to_s);
}

const char* kind_of(double level, double quiet, const Moments& moments) {
  if (level < quiet) return "silent";
  if (moments.right_share() >= kRightShare) return "right note";
  return moments.partials > moments.strays() ? "wrong partial" : "howl";
}

/// One note; the last two readings are of all.
JudgedRun judge_note(std::span<const double> steady, const std::vector<PitchPoint>& track, const Wanted& note,
                     double quiet) {
  JudgedRun run{"silent", 0, false, {}};
  const double level = rms_of(steady);
  const auto moments = moments_of(track, note);
  const double start = stands_in(track, moments, note) - note.from_s;
  const double spread = spread_of(moments.level);
  const double pitch = median(moments.hertz);
  const int partial = pitch > 0 ? partial_of(pitch, note.hertz) : 0;
  run.kind = kind_of(level, quiet, moments);
  if (run.kind != "silent")
    run.score = moments.right_share() * kPrompt_s / std::max(start, kPrompt_s) * kSteadySpread /
                std::max(spread, kSteadySpread);
  run.playable = run.kind == "right note" && run.score >= kLeastScore;
  run.readings = {start,
                  static_cast<double>(partial),
                  pitch > 0 ? cents(pitch, std::max(1, partial) * note.hertz) : 0,
                  moments.right_share(),
                  spread,
                  swing_of(moments.hertz),
                  level,
                  1,
                  run.playable ? 1.0 : 0.0};
  return run;
}

/// Half of what the tracker looks at around a moment: three periods of the lowest pitch.
double reach_s(double lowest_hz) { return 1.5 / lowest_tracked(Hertz{lowest_hz}).value; }

Wanted held_note(const SceneRecording& recording, const Playability& judged) {
  const double end = judged.to_s.value_or(recording.seconds());
  return {judged.begin_s, end, judged.from_s, std::min(end, recording.seconds() - 10 / judged.pitch_hz),
          judged.pitch_hz};
}

/// Those that sound between `begin` and `to`. Each has as long to settle as the first, at most half its time.
std::vector<Wanted> notes_of(const SceneRecording& recording, const Playability& judged) {
  if (judged.pitch.name.empty()) return {held_note(recording, judged)};
  const auto* wanted = recording.find(judged.pitch.name);
  if (wanted == nullptr) return {};
  const double end = judged.to_s.value_or(recording.seconds());
  std::vector<Wanted> notes;
  double lowest = kUnlimited;
  for (const auto& note : wanted_notes(wanted->samples, recording.sample_rate)) {
    const double from = std::max(judged.begin_s, note.from_s), to = std::min(end, note.to_s);
    if (to - from < kShortestTone_s) continue;
    const double settles = std::min(judged.from_s - judged.begin_s, 0.5 * (to - from));
    notes.push_back({from, to, from + settles, to, note.hertz, wanted->samples, recording.sample_rate.value});
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
JudgedRun together(const std::vector<JudgedRun>& notes) {
  const auto worse = [](const JudgedRun& a, const JudgedRun& b) {
    return a.playable != b.playable ? !a.playable : a.score < b.score;
  };
  auto run = *std::min_element(notes.begin(), notes.end(), worse);
  double score = 0, good = 0;
  for (const auto& note : notes) {
    score += note.score;
    good += note.playable ? 1 : 0;
  }
  const auto count = static_cast<double>(notes.size());
  run.score = score / count;
  run.readings[run.readings.size() - 2] = count;
  run.readings.back() = good;
  return run;
}

}  // namespace

const std::vector<ReadingType>& tone_readings() {
  static const std::vector<ReadingType> readings = {
      {"start_s", "speaks s", 2, "from the bow to a tone that stands", true},
      {"partial", "partial", 0, "of the note wanted, nearest to what sounds; 0: none"},
      {"cents", "cents", 1, "what sounds over that partial, or over the note", true},
      {"right", "right", 2, "share of the moments with the note wanted", true},
      {"level_spread", "unsteady", 2, "standard deviation of the level over its mean", true},
      {"swing_cents", "swing", 1, "how far its pitch swings, the middle nine tenths [cents]"},
      {"rms", "rms", 3, "root mean square [full scale]"},
      {"notes", "notes", 0, "that were wanted; what stands before is of the one with the least score"},
      {"good", "good", 0, "notes that are playable"},
  };
  return readings;
}

const std::vector<RunKind>& tone_kinds() {
  static const std::vector<RunKind> kinds = {
      {"right note", 'N', "in tune within 25 cents in 9 of 10 moments"},
      {"wrong partial", 'p', "mostly another partial of the note"},
      {"howl", 'h', "another pitch, or none"},
      {"silent", '.', "softer than is asked"},
  };
  return kinds;
}

JudgedRun judge_tone(const SceneRecording& recording, const Playability& judged) {
  const auto* sound = recording.find(judged.sound.name);
  const auto notes = notes_of(recording, judged);
  if (sound == nullptr || notes.empty())
    return {"silent", 0, false, std::vector<double>(tone_readings().size(), 0.0)};
  const auto [low, high] = std::minmax_element(
      notes.begin(), notes.end(), [](const Wanted& a, const Wanted& b) { return a.hertz < b.hertz; });
  const auto rate = recording.sample_rate;
  // The tracker leaves out both ends of what it is given.
  auto track = track_notes(between(*sound, rate, judged.begin_s, recording.seconds()), rate,
                           Hertz{low->hertz}, Hertz{high->hertz});
  for (auto& point : track) point.time_s += judged.begin_s;
  std::vector<JudgedRun> runs;
  for (const auto& note : notes)
    runs.push_back(judge_note(between(*sound, rate, note.steady_s, note.to_s), track, note, judged.quiet));
  return together(runs);
}

}  // namespace tactus
