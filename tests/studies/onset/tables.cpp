#include "tests/studies/onset/tables.h"

#include <cstdio>
#include <functional>
#include <map>

namespace tactus::study {
namespace {

using Key = std::function<std::string(const TrueHit&)>;  ///< the row of a hit; empty: none

std::string table(const std::string& title, const std::vector<Outcome>& outcomes, const Key& key) {
  std::map<std::string, Score> rows;
  for (const Outcome& outcome : outcomes)
    if (const std::string row = key(outcome.hit); !row.empty()) rows[row].add(outcome.score);
  std::string text =
      "\n| " + title +
      " | hits | found | missed | doubled or false | fast: p50 ms | p95 | max | others: p50 ms | "
      "p95 | max |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [row, score] : rows) text += "| " + row + " |" + score.cells() + "\n";
  return text;
}

std::string rate_of(const TrueHit& hit) {
  char text[32];
  std::snprintf(text, sizeof text, "%2.0f hits/s", hit.rate);
  return text;
}

std::string level_of(const TrueHit& hit) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f dBFS", hit.level_db);
  return text;
}

bool goal(const TrueHit& hit) { return hit.pattern == "steady" && hit.rate <= 15; }

}  // namespace

std::string tables(const std::vector<Outcome>& outcomes) {
  std::string text = table("goal: steady, 4 to 15 hits/s, 0 to -30 dBFS", outcomes, [](const TrueHit& hit) {
    return goal(hit) ? std::string(hit.training ? "half for tuning" : "other half") : "";
  });
  std::vector<Outcome> unseen;
  for (const Outcome& outcome : outcomes)
    if (!outcome.hit.training) unseen.push_back(outcome);
  text += "\nAll that follows is the other half.\n";
  text += table("goal, by ringing", unseen, [](const TrueHit& hit) {
    return goal(hit)
               ? std::string(hit.rings ? "falls by less than 6 dB to the next" : "falls by 6 dB or more")
               : "";
  });
  text += table("steady", unseen, [](const TrueHit& hit) {
    return hit.pattern == "steady" ? rate_of(hit) + ", " + level_of(hit) : "";
  });
  text += table("goal, by noise", unseen, [](const TrueHit& hit) { return goal(hit) ? hit.noise : ""; });
  text += table("goal, by drum", unseen, [](const TrueHit& hit) { return goal(hit) ? hit.kind : ""; });
  text += table("-40 dBFS, threshold -46 dB", unseen,
                [](const TrueHit& hit) { return hit.pattern == "soft" ? hit.noise : ""; });
  text += table("patterns", unseen, [](const TrueHit& hit) {
    const bool plain = hit.pattern == "steady" || hit.pattern == "soft";
    return plain ? "" : hit.pattern + ", " + rate_of(hit);
  });
  text += table("accents: the soft hits", unseen, [](const TrueHit& hit) {
    const bool soft = hit.pattern.starts_with("accent") && hit.level_db != 0 && hit.level_db != -10;
    return soft ? hit.pattern + ", " + rate_of(hit) : "";
  });
  return text;
}

}  // namespace tactus::study
