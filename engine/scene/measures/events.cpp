#include "engine/scene/measures/events.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/median.h"

namespace tactus {
namespace {

constexpr Seconds kOneStrike = 15_ms;  // two so close count as one

int longest_growth(const std::vector<double>& intervals) {
  int longest = 0;
  int run = 0;
  for (std::size_t i = 1; i < intervals.size(); ++i) {
    run = intervals[i] >= 1.03 * intervals[i - 1] ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  return longest;
}

int fewest_per_second(const std::vector<double>& times, double from, double to) {
  if (to - from < 1) return 0;
  int fewest = static_cast<int>(times.size());
  for (double start = from; start + 1 <= to + 1e-9; start += 0.1)
    fewest = std::min(fewest, events_in_second(times, start));
  return fewest;
}

}  // namespace

std::vector<double> trigger_times(const std::vector<double>& samples, Hertz sample_rate) {
  std::vector<double> times;
  bool high = false;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const bool now = samples[n] > 0.5;
    if (now && !high) times.push_back(static_cast<double>(n) / sample_rate.value);
    high = now;
  }
  return times;
}

std::vector<Strike> find_strikes(const std::vector<double>& force, Hertz sample_rate, Seconds gap,
                                 double least) {
  std::vector<Strike> strikes;
  for (std::size_t n = 0; n < force.size(); ++n) {
    if (force[n] <= 0) continue;
    const double now = static_cast<double>(n) / sample_rate.value;
    if (strikes.empty() || now - strikes.back().end_s > gap.value) strikes.push_back({now, now, 0});
    strikes.back().end_s = now;
    strikes.back().peak = std::max(strikes.back().peak, force[n]);
  }
  std::erase_if(strikes, [least](const Strike& strike) { return strike.peak < least; });
  return strikes;
}

int events_in_second(const std::vector<double>& times_s, double from_s) {
  const auto first = std::ranges::lower_bound(times_s, from_s);
  return static_cast<int>(std::ranges::lower_bound(times_s, from_s + 1) - first);
}

Rhythm rhythm_of(const std::vector<double>& times_s, double from_s, double to_s) {
  std::vector<double> times;
  for (const double time : times_s)
    if (time >= from_s && time <= to_s) times.push_back(time);
  Rhythm rhythm;
  rhythm.count = static_cast<int>(times.size());
  rhythm.fewest_in_a_second = fewest_per_second(times, from_s, to_s);
  if (times.empty()) return rhythm;
  rhythm.last_s = times.back();
  if (times.size() < 3) return rhythm;
  std::vector<double> intervals, ratios;
  for (std::size_t i = 1; i < times.size(); ++i) intervals.push_back(times[i] - times[i - 1]);
  const double mean = (times.back() - times.front()) / static_cast<double>(intervals.size());
  double squares = 0;
  for (const double interval : intervals) squares += (interval - mean) * (interval - mean);
  for (std::size_t i = 1; i < intervals.size(); ++i)
    ratios.push_back(std::max(intervals[i], intervals[i - 1]) / std::min(intervals[i], intervals[i - 1]));
  rhythm.rate_hz = 1 / mean;
  rhythm.spread = std::sqrt(squares / static_cast<double>(intervals.size())) / mean;
  rhythm.long_short = median(std::move(ratios));
  rhythm.growing = longest_growth(intervals);
  return rhythm;
}

double restitution(const std::vector<double>& position, Hertz sample_rate,
                   const std::vector<Strike>& strikes) {
  const auto span = static_cast<std::ptrdiff_t>(1e-3 * sample_rate.value);
  const auto at = [&](std::ptrdiff_t n) { return position[static_cast<std::size_t>(n)]; };
  double sum = 0;
  int count = 0;
  for (const auto& strike : strikes) {
    const auto start = static_cast<std::ptrdiff_t>(strike.start_s * sample_rate.value);
    const auto end = static_cast<std::ptrdiff_t>(strike.end_s * sample_rate.value) + 1;
    if (start < span || end + span >= static_cast<std::ptrdiff_t>(position.size())) continue;
    const double before = at(start) - at(start - span);
    const double after = at(end + span) - at(end);
    if (before >= 0 || after <= 0) continue;
    sum += std::log(after / -before);
    ++count;
  }
  return count == 0 ? 0 : std::exp(sum / count);
}

Detection match(const std::vector<Strike>& touches, const std::vector<double>& triggers_s, double least) {
  Detection detection;
  std::vector<bool> detected(touches.size(), false);
  for (const double time : triggers_s) {
    const auto after = std::ranges::upper_bound(touches, time, {}, &Strike::start_s);
    const auto touch = static_cast<std::size_t>(after - touches.begin()) - 1;
    if (after == touches.begin() || time - touches[touch].start_s > kDetectionDelay.value ||
        detected[touch]) {
      ++detection.doubled;
      continue;
    }
    detected[touch] = true;
    ++detection.found;
    detection.found_s.push_back(time);
    detection.latest_s = std::max(detection.latest_s, time - touches[touch].start_s);
  }
  for (std::size_t i = 0; i < touches.size(); ++i) {
    if (detected[i] || touches[i].peak < least) continue;
    const double start = touches[i].start_s;
    const auto next = std::ranges::upper_bound(triggers_s, start);
    if (next == triggers_s.begin() || start - *(next - 1) >= kOneStrike.value) ++detection.missed;
  }
  return detection;
}

}  // namespace tactus
