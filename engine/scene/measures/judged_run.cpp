#include "engine/scene/measures/judged_run.h"

#include <algorithm>

#include "engine/scene/measures/roll.h"
#include "engine/scene/measures/tone.h"

namespace tactus {

double JudgedRun::reading(Playability::Kind judged_by, const std::string& name) const {
  const auto& columns = measure_columns(judged_by);
  const auto found =
      std::find_if(columns.begin(), columns.end(), [&](const auto& column) { return column.name == name; });
  return readings.at(static_cast<std::size_t>(found - columns.begin()));
}

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
      {"swing_cents", "swing", 1, "swing"},
      {"rms", "rms", 3, "tone_level"},
      {"notes", "notes", 0, "notes"},
      {"good", "good", 0, "good_notes"},
  };
  return kind == Playability::Kind::Roll ? roll : tone;
}

std::vector<double> column_values(Playability::Kind kind, const Window& window) {
  std::vector<double> values;
  for (const auto& column : measure_columns(kind))
    values.push_back(find_measure(column.measure)->value(window));
  return values;
}

const std::vector<RunKind>& run_kinds(Playability::Kind kind) {
  return kind == Playability::Kind::Roll ? roll_kinds() : tone_kinds();
}

JudgedRun judge(const SceneRecording& recording, const Playability& judged) {
  return judged.kind == Playability::Kind::Roll ? judge_roll(recording, judged)
                                                : tone_of(recording, judged).run;
}

}  // namespace tactus
