#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/studies/onset/layout.h"

namespace tactus::study {

/// Counts and times of any number of hits.
struct Score {
  int hits = 0, found = 0, extra = 0;
  std::vector<double> fast_s, slow_s;  ///< detection times of the hits found

  void add(const Score& other);
  /// "hits | found | missed | extra | fast p50 | p95 | max | other p50 | p95 | max", times in ms.
  std::string cells() const;
};

/// One entry for each true hit, in its order: found or not, and the extra detections (doubles and false
/// alarms) between it and the next. A detection belongs to the hit whose onset lies at most 5 ms after and 20
/// ms before it, and to one only.
std::vector<Score> match(const std::vector<TrueHit>& hits, const std::vector<double>& detections_s);

}  // namespace tactus::study
