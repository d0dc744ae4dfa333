#include "engine/scene/measures/roll.h"

#include <algorithm>
#include <cmath>

#include "engine/scene/measures/events.h"
#include "engine/scene/measures/measure.h"

namespace tactus {
namespace {

constexpr int kMostBeats = 4;
constexpr double kRepeats = 0.02;  // a pattern that close needs no longer one
constexpr std::size_t kLeastHits = 6;
constexpr double kWindow_s = 1.0, kJudgedRollStep_s = 0.1;

double pattern_spread(const std::vector<double>& intervals, std::size_t beats, double mean) {
  if (intervals.size() <= beats) return 1;
  double squares = 0;
  for (std::size_t i = beats; i < intervals.size(); ++i)
    squares += (intervals[i] - intervals[i - beats]) * (intervals[i] - intervals[i - beats]);
  return std::sqrt(squares / (2 * static_cast<double>(intervals.size() - beats))) / mean;
}

double detected_share(const Detection& detection) {
  const int all = detection.found + detection.missed + detection.doubled;
  return all == 0 ? 0 : static_cast<double>(detection.found) / all;
}

const char* kind_of(bool lives, const Evenness& even) {
  if (!lives) return "dead";
  if (even.spread <= kEvenSpread) return "regular";
  return even.pattern_spread <= kEvenSpread ? "gallop" : "irregular";
}

}  // namespace

double sustained(const std::vector<double>& times, double from, double to, double fewest) {
  int windows = 0, alive = 0;
  for (int i = 0; from + i * kJudgedRollStep_s + kWindow_s <= to + 1e-9; ++i, ++windows) {
    const auto begin = from + i * kJudgedRollStep_s;
    const auto first = std::lower_bound(times.begin(), times.end(), begin);
    const auto last = std::lower_bound(first, times.end(), begin + kWindow_s);
    alive += static_cast<double>(last - first) >= fewest ? 1 : 0;
  }
  return windows == 0 ? 0 : static_cast<double>(alive) / windows;
}

Evenness evenness_of(const std::vector<double>& times_s) {
  if (times_s.size() < kLeastHits) return {1, 1, 1};
  std::vector<double> intervals;
  for (std::size_t i = 1; i < times_s.size(); ++i) intervals.push_back(times_s[i] - times_s[i - 1]);
  const double mean = (times_s.back() - times_s.front()) / static_cast<double>(intervals.size());
  Evenness even{rhythm_of(times_s, times_s.front(), times_s.back()).spread, 1,
                pattern_spread(intervals, 1, mean)};
  for (int beats = 2; beats <= kMostBeats; ++beats) {
    const double spread = pattern_spread(intervals, static_cast<std::size_t>(beats), mean);
    if (even.pattern_spread > kRepeats && spread < 0.9 * even.pattern_spread)
      even.beats = beats, even.pattern_spread = spread;
  }
  return even;
}

const std::vector<RunKind>& roll_kinds() {
  static const std::vector<RunKind> kinds = {
      {"regular", 'R', "intervals spread by at most 15 %"},
      {"gallop", 'G', "a pattern of two to four strikes that repeats within 15 %: short and long"},
      {"irregular", 'i', "strikes go on, and no pattern repeats"},
      {"dead", '.', "some second has fewer strikes than [playability] asks for"},
  };
  return kinds;
}

JudgedRun judge_roll(const SceneRecording& recording, const Playability& judged) {
  Window window{recording, judged.from_s, judged.to_s};
  window.playability = &judged;
  const auto* contact = recording.find(judged.contact.name);
  const auto detection =
      contact == nullptr ? Detection{}
                         : detection_of(*contact, recording.sample_rate,
                                        triggers_of(recording, judged.hits.name), window.from_s, window.to_s);
  const auto& hits = detection.found_s;
  const auto even = evenness_of(hits);
  const double lasts = sustained(hits, window.from_s, window.to_s, judged.fewest);
  const bool lives = lasts == 1.0;
  JudgedRun run;
  run.kind = kind_of(lives, even);
  run.score = lasts * detected_share(detection) *
              std::min(1.0, kEvenSpread / std::max(even.pattern_spread, kEvenSpread));
  run.playable = lives && run.score >= kLeastScore;
  window.events = hits;
  window.detection = &detection;
  run.readings = column_values(Playability::Kind::Roll, window);
  return run;
}

}  // namespace tactus
