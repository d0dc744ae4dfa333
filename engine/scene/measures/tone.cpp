#include <algorithm>
#include <cmath>
#include <span>

#include "engine/core/decibels.h"
#include "engine/core/median.h"
#include "engine/scene/measures/notes/pitch_track.h"
#include "engine/scene/measures/playability_result.h"

namespace tactus {
namespace {

constexpr double kRightShare = 0.9;      // of a right note
constexpr double kShortestTone_s = 0.2;  // of a note that is evaluated

/// An expected note, from where it begins to where it ends.
struct ToneNote {
  double from_s, to_s;
  double steady_s;                      ///< from here on it should be steady
  double until_s;                       ///< and up to here no window reaches into the next
  double hertz;                         ///< median
  std::span<const double> moving = {};  ///< pitch of each frame of the scene; empty: it does not move
  double rate = 0;

  std::vector<ToneMoment> moments(const std::vector<PitchPoint>& track, double from, double to) const {
    return moments_between(track, from, to, [this](double time_s) {
      const auto frame = static_cast<std::size_t>(time_s * rate);
      return frame < moving.size() && moving[frame] > 0 ? moving[frame] : hertz;
    });
  }
};

/// The moments of the part that should be steady.
struct SteadyMoments {
  double frames;  ///< that there are, with a pitch or without
  double right, partials, in_tune;
  std::vector<double> hertz, off_cents, level;

  double right_share() const { return right / frames; }
  double strays() const { return frames - right - partials; }
};

SteadyMoments steady_moments_of(const std::vector<PitchPoint>& track, const ToneNote& note) {
  const auto all = note.moments(track, note.steady_s, note.until_s);
  SteadyMoments steady{std::max(1.0, std::floor((note.until_s - note.steady_s) / kPitchHop_s)),
                       0,
                       0,
                       0,
                       each(all, &ToneMoment::hertz),
                       each(all, &ToneMoment::off_cents),
                       each(all, &ToneMoment::rms)};
  for (const auto& moment : all) {
    const int partial = partial_of(moment.hertz, moment.expected_hz);
    if (partial == 1 && std::abs(moment.off_cents()) <= kInTune_cents) ++steady.right;
    if (partial == 1) steady.in_tune += near(moment.off_cents(), kHalfCents);
    if (partial > 1) ++steady.partials;
  }
  steady.right = std::min(steady.right, steady.frames);
  steady.in_tune = std::min(1.0, steady.in_tune / steady.frames);
  return steady;
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
double steady_in(const std::vector<PitchPoint>& track, const SteadyMoments& moments, const ToneNote& note) {
  if (moments.hertz.empty()) return note.to_s;
  return steady_from(note.moments(track, note.from_s, note.to_s), median(moments.off_cents),
                     median(moments.level))
      .value_or(note.to_s);
}

const char* kind_of(double level, double quiet, const SteadyMoments& moments) {
  if (level < quiet) return "silent";
  if (moments.right_share() >= kRightShare) return "right note";
  return moments.partials > moments.strays() ? "wrong partial" : "howl";
}

/// The energy in the beginning of a note that does not come back after a period, over that of as long of the
/// tone itself, if that is more: 0 of what repeats itself, 1 of noise.
double noise_of(std::span<const double> onset, double period, double level) {
  const auto whole = static_cast<std::size_t>(period);
  const double share = period - static_cast<double>(whole);
  // The straight line between two samples takes some of the noise away.
  const double kept = 0.5 * (1 + (1 - share) * (1 - share) + share * share);
  double differences = 0, energy = 0, tone = 0;
  for (std::size_t n = whole + 1; n < onset.size(); ++n) {
    const double before = (1 - share) * onset[n - whole] + share * onset[n - whole - 1];
    differences += (onset[n] - before) * (onset[n] - before);
    energy += onset[n] * onset[n] + before * before;
    tone += 2 * level * level;
  }
  return differences > 0 ? std::min(1.0, differences / kept / std::max(energy, tone)) : 0;
}

ToneResult evaluate_note(std::span<const double> onset, std::span<const double> steady, Hertz rate,
                         const std::vector<PitchPoint>& track, const ToneNote& note, double quiet) {
  ToneResult tone;
  auto& [run, values] = tone;
  const auto moments = steady_moments_of(track, note);
  const double pitch = median(moments.hertz);
  values.start_s = steady_in(track, moments, note) - note.from_s;
  values.partial = pitch > 0 ? partial_of(pitch, note.hertz) : 0;
  values.cents = pitch > 0 ? cents(pitch, std::max(1, values.partial) * note.hertz) : 0;
  values.right = moments.right_share();
  values.in_tune = moments.in_tune;
  values.level_spread = spread_of(moments.level);
  values.swing_cents = swing_of(moments.hertz);
  values.level = rms_of(steady);
  values.onset_noise = noise_of(onset, rate.value / note.hertz, values.level);
  run.kind = kind_of(values.level, quiet, moments);
  if (run.kind != "silent")
    run.score = values.in_tune * near(values.start_s, kHalfStart_s) *
                near(values.level_spread, kHalfUnsteady) * near(values.onset_noise, kHalfNoise);
  run.playable = run.kind == "right note" && run.score >= kLeastScore;
  return tone;
}

ToneNote held_note(const SceneRecording& recording, const Playability& playability) {
  const double end = playability.to_s.value_or(recording.seconds());
  return {playability.begin_s, end, playability.from_s,
          std::min(end, recording.seconds() - 10 / playability.pitch_hz), playability.pitch_hz};
}

/// Those that sound between `begin` and `to`. Each has as long to settle as the first, at most half its time.
std::vector<ToneNote> notes_of(const SceneRecording& recording, const Playability& playability) {
  if (playability.pitch.name.empty()) return {held_note(recording, playability)};
  const auto* expected = recording.find(playability.pitch.name);
  if (expected == nullptr) return {};
  const double end = playability.to_s.value_or(recording.seconds());
  std::vector<ToneNote> notes;
  double lowest = kUnlimited;
  for (const auto& note : expected_notes(expected->samples, recording.sample_rate)) {
    const double from = std::max(playability.begin_s, note.from_s), to = std::min(end, note.to_s);
    if (to - from < kShortestTone_s) continue;
    const double settles = std::min(playability.from_s - playability.begin_s, 0.5 * (to - from));
    notes.push_back(
        {from, to, from + settles, to, note.hertz, expected->samples, recording.sample_rate.value});
    lowest = std::min(lowest, note.hertz);
  }
  // No moment counts whose window (three periods of the lowest pitch) reaches into the next note, or beyond
  // the end.
  const double reach_s = 1.5 / lowest_tracked(Hertz{lowest}).value;
  for (auto& note : notes) {
    const bool last = &note == &notes.back();
    const double edge = last ? recording.seconds() - 10 / note.hertz : note.to_s - reach_s;
    note.until_s = std::max(note.steady_s, std::min(note.to_s, edge));
  }
  return notes;
}

/// Standard deviation of the levels of those that sound.
double level_deviation_db(const std::vector<ToneResult>& notes) {
  double count = 0, sum = 0, squares = 0;
  for (const auto& note : notes) {
    if (note.run.kind == "silent") continue;
    const double level = amplitude_to_db(note.values.level);
    ++count;
    sum += level;
    squares += level * level;
  }
  return count > 1 ? std::sqrt(std::max(0.0, squares / count - sum / count * (sum / count))) : 0;
}

/// All notes as one run.
ToneResult together(const std::vector<ToneResult>& notes) {
  const auto worse = [](const ToneResult& a, const ToneResult& b) {
    return a.run.playable != b.run.playable ? !a.run.playable : a.run.score < b.run.score;
  };
  auto all = *std::ranges::min_element(notes, worse);
  double score = 0;
  for (const auto& note : notes) {
    score += note.run.score;
    all.values.good_notes += note.run.playable ? 1 : 0;
  }
  all.values.notes = static_cast<int>(notes.size());
  all.values.level_deviation_db = level_deviation_db(notes);
  all.run.score =
      score / static_cast<double>(notes.size()) * near(all.values.level_deviation_db, kHalfLevel_db);
  return all;
}

}  // namespace

ToneResult tone_of(const SceneRecording& recording, const Playability& playability) {
  const auto* sound = recording.find(playability.sound.name);
  const auto notes = notes_of(recording, playability);
  Window window{recording, playability.from_s, playability.to_s};
  window.playability = &playability;
  ToneResult tone{{"silent", 0, false, {}}, {}};
  if (sound != nullptr && !notes.empty()) {
    const auto [low, high] = std::ranges::minmax_element(notes, {}, &ToneNote::hertz);
    // The tracker leaves out both ends of what it is given.
    auto track = track_notes(Window{recording, playability.begin_s, {}}.samples(*sound),
                             recording.sample_rate, Hertz{low->hertz}, Hertz{high->hertz});
    for (auto& point : track) point.time_s += playability.begin_s;
    std::vector<ToneResult> tones;
    for (const auto& note : notes) {
      const auto steady = Window{recording, note.steady_s, note.to_s}.samples(*sound);
      const auto onset = Window{recording, note.from_s, std::min(note.to_s, note.from_s + kOnset_s)};
      tones.push_back(evaluate_note(onset.samples(*sound), steady, recording.sample_rate, track, note,
                                    playability.quiet));
    }
    tone = together(tones);
  }
  window.tone = &tone.values;
  tone.run.readings = readings_of(window);
  return tone;
}

}  // namespace tactus
