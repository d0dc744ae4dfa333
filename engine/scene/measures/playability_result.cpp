#include "engine/scene/measures/playability_result.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/core/decibels.h"
#include "engine/scene/measures/events.h"

namespace tactus {
namespace {

constexpr int kMaxBeats = 4;
constexpr double kRepeats = 0.02;  // a pattern that close needs no longer one
constexpr std::size_t kMinHits = 6;
constexpr double kStep_s = 0.1;

/// How far values are from those `beats` before them, root mean square / sqrt(2).
std::optional<double> spread_over(const std::vector<double>& values, std::size_t beats) {
  if (values.size() <= beats) return std::nullopt;
  double squares = 0;
  for (std::size_t i = beats; i < values.size(); ++i)
    squares += (values[i] - values[i - beats]) * (values[i] - values[i - beats]);
  return std::sqrt(squares / (2 * static_cast<double>(values.size() - beats)));
}

double pattern_spread(const std::vector<double>& intervals, std::size_t beats, double mean) {
  const auto spread = spread_over(intervals, beats);
  return spread ? *spread / mean : 1;
}

double detected_share(const Detection& detection) {
  const int all = detection.found + detection.missed + detection.doubled;
  return all == 0 ? 0 : static_cast<double>(detection.found) / all;
}

const char* kind_of(bool lives, const Evenness& even, const Rhythm& rhythm, Playability::Roll wanted) {
  if (!lives) return "dead";
  if (wanted == Playability::Roll::Backwards && rhythm.growing >= kFewestGrowing) return "backwards";
  if (even.spread <= kEvenSpread) return "regular";
  return even.pattern_spread <= kEvenSpread ? "gallop" : "irregular";
}

double rhythm_share(const Evenness& even, const Rhythm& rhythm, Playability::Roll wanted) {
  const double repeats = near(even.pattern_spread, kHalfSpread);
  switch (wanted) {
    case Playability::Roll::Even:
      return near(even.spread, kHalfSpread);
    case Playability::Roll::Any:
      return repeats;
    case Playability::Roll::Gallop:
      return repeats * (1 - near(std::log(std::max(1.0, rhythm.long_short)), std::log(kHalfRatio)));
    case Playability::Roll::Backwards:
      return std::pow(std::min(1.0, static_cast<double>(rhythm.growing) / kFewestGrowing), 2);
  }
  return 0;
}

std::vector<Strike> strikes_between(const RecordedSignal& contact, const Window& window) {
  auto strikes = strikes_in(contact, window.rate());
  std::erase_if(strikes, [&](const Strike& strike) {
    return strike.start_s < window.from_s || strike.start_s > window.to_s;
  });
  return strikes;
}

PlayabilityResult evaluate_roll(const SceneRecording& recording, const Playability& playability) {
  Window window{recording, playability.from_s, playability.to_s};
  window.playability = &playability;
  const auto* contact = recording.find(playability.contact.name);
  const auto detection = contact == nullptr ? Detection{}
                                            : detection_of(*contact, recording.sample_rate,
                                                           triggers_of(recording, playability.hits.name),
                                                           window.from_s, window.to_s);
  const auto& hits = detection.found_s;
  const auto even = evenness_of(hits);
  const double lasts = sustained(hits, window.from_s, window.to_s, playability.fewest);
  const bool lives = lasts == 1.0;
  const auto rhythm = rhythm_of(hits, window.from_s, window.to_s);
  PlayabilityResult run;
  run.kind = kind_of(lives, even, rhythm, playability.roll);
  run.score = lasts * detected_share(detection) * rhythm_share(even, rhythm, playability.roll);
  if (contact != nullptr && playability.roll != Playability::Roll::Backwards)
    run.score *= near(loudness_spread(strikes_between(*contact, window), even.beats), kHalfLoudness_db);
  if (playability.rate_hz && rhythm.rate_hz > 0)
    run.score *= near(std::log(rhythm.rate_hz / *playability.rate_hz), std::log(kHalfRate));
  run.playable = lives && run.score >= kLeastScore;
  window.events = hits;
  window.detection = &detection;
  run.readings = readings_of(window);
  return run;
}

}  // namespace

const std::vector<MeasureColumn>& measure_columns(Playability::Kind kind) {
  static const std::vector<MeasureColumn> roll = {
      {"rate_hz", "hits/s", 1, "rate", true},
      {"fewest", "worst s", 0, "fewest_per_second", true},
      {"sustained", "lasts", 2, "sustained"},
      {"last_s", "last s", 2, "last"},
      {"spread", "spread", 2, "even_spread", true},
      {"beats", "beats", 0, "beats"},
      {"pattern_spread", "pattern", 2, "pattern_spread"},
      {"long_short", "long/short", 2, "long_short", true},
      {"growing", "growing", 0, "growing"},
      {"strikes", "strikes", 0, "detected"},
      {"missed", "missed", 0, "missed"},
      {"doubled", "doubled", 0, "doubled"},
  };
  static const std::vector<MeasureColumn> tone = {
      {"start_s", "onset s", 2, "onset_time", true},
      {"partial", "partial", 0, "partial"},
      {"cents", "cents", 1, "cents", true},
      {"right", "right", 2, "right_share", true},
      {"level_spread", "unsteady", 2, "level_spread", true},
      {"onset_noise", "noise", 2, "onset_noise", true},
      {"swing_cents", "swing", 1, "swing"},
      {"rms", "rms", 3, "tone_level"},
      {"notes", "notes", 0, "notes"},
      {"note_levels_db", "levels dB", 1, "note_levels"},
      {"good", "good", 0, "good_notes"},
  };
  return kind == Playability::Kind::Roll ? roll : tone;
}

std::vector<double> readings_of(const Window& window) {
  std::vector<double> values;
  for (const auto& column : measure_columns(window.playability->kind))
    values.push_back(find_measure(column.measure)->value(window));
  return values;
}

const std::vector<RunKind>& run_kinds(Playability::Kind kind) {
  static const std::vector<RunKind> roll = {
      {"regular", 'R', "intervals spread by at most 15 %"},
      {"gallop", 'G', "a pattern of two to four strikes that repeats within 15 %: short and long"},
      {"backwards", 'b', "six intervals or more that grow, where that is wanted"},
      {"irregular", 'i', "strikes continue without a repeating pattern"},
      {"dead", '.', "in at least one second, fewer strikes than [playability] requires"},
  };
  static const std::vector<RunKind> tone = {
      {"right note", 'N', "in tune within 25 cents for 90 % of the time"},
      {"wrong partial", 'p', "mostly another partial of the note"},
      {"howl", 'h', "another pitch, or none"},
      {"silent", '.', "level below 'quiet'"},
  };
  return kind == Playability::Kind::Roll ? roll : tone;
}

double sustained(const std::vector<double>& times, double from, double to, double fewest) {
  int windows = 0, alive = 0;
  for (; from + windows * kStep_s + 1 <= to + 1e-9; ++windows)
    alive += events_in_second(times, from + windows * kStep_s) >= fewest ? 1 : 0;
  return windows == 0 ? 0 : static_cast<double>(alive) / windows;
}

Evenness evenness_of(const std::vector<double>& times_s) {
  if (times_s.size() < kMinHits) return {1, 1, 1};
  std::vector<double> intervals;
  for (std::size_t i = 1; i < times_s.size(); ++i) intervals.push_back(times_s[i] - times_s[i - 1]);
  const double mean = (times_s.back() - times_s.front()) / static_cast<double>(intervals.size());
  Evenness even{rhythm_of(times_s, times_s.front(), times_s.back()).spread, 1,
                pattern_spread(intervals, 1, mean)};
  for (int beats = 2; beats <= kMaxBeats; ++beats) {
    const double spread = pattern_spread(intervals, static_cast<std::size_t>(beats), mean);
    if (even.pattern_spread > kRepeats && spread < 0.9 * even.pattern_spread)
      even.beats = beats, even.pattern_spread = spread;
  }
  return even;
}

double loudness_spread(const std::vector<Strike>& strikes, int beats) {
  std::vector<double> levels;
  for (const auto& strike : strikes) levels.push_back(amplitude_to_db(strike.peak));
  return spread_over(levels, static_cast<std::size_t>(beats)).value_or(0);
}

PlayabilityResult evaluate(const SceneRecording& recording, const Playability& playability) {
  return playability.kind == Playability::Kind::Roll ? evaluate_roll(recording, playability)
                                                     : tone_of(recording, playability).run;
}

}  // namespace tactus
