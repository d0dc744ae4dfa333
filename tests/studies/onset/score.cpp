#include "tests/studies/onset/score.h"

#include <algorithm>
#include <cstdio>

namespace tactus::study {

namespace {

std::string times(std::vector<double> seconds) {
  if (seconds.empty()) return " | | |";
  std::sort(seconds.begin(), seconds.end());
  const auto at = [&](double part) {
    return 1e3 * seconds[static_cast<std::size_t>(part * static_cast<double>(seconds.size() - 1) + 0.5)];
  };
  char text[64];
  std::snprintf(text, sizeof text, " %.2f | %.2f | %.2f |", at(0.5), at(0.95), at(1));
  return text;
}

}  // namespace

std::string Score::cells() const {
  return " " + std::to_string(hits) + " | " + std::to_string(found) + " | " + std::to_string(hits - found) +
         " | " + std::to_string(extra) + " |" + times(fast_s) + times(slow_s);
}

void Score::add(const Score& other) {
  hits += other.hits;
  found += other.found;
  extra += other.extra;
  fast_s.insert(fast_s.end(), other.fast_s.begin(), other.fast_s.end());
  slow_s.insert(slow_s.end(), other.slow_s.begin(), other.slow_s.end());
}

std::vector<Score> match(const std::vector<TrueHit>& hits, const std::vector<double>& detections_s) {
  std::vector<Score> scores(hits.size());
  std::size_t next = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    Score& score = scores[i];
    score.hits = 1;
    const double limit = i + 1 < hits.size() ? hits[i + 1].time_s - 0.005 : 1e99;
    for (; next < detections_s.size() && detections_s[next] < limit; ++next) {
      const double late = detections_s[next] - hits[i].time_s;
      if (score.found || late < -0.005 || late > 0.020) {
        ++score.extra;
        continue;
      }
      score.found = 1;
      (hits[i].fast ? score.fast_s : score.slow_s).push_back(late);
    }
  }
  return scores;
}

}  // namespace tactus::study
