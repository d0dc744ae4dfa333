#pragma once

#include <string>
#include <vector>

#include "engine/scene/measures/measure.h"

// Thread: [control]

namespace tactus {

/// How one run of a scene was to play. docs/playability.md says why it is judged so.
struct JudgedRun {
  std::string kind;              ///< one of `run_kinds`
  double score = 0;              ///< 0 nothing, 1 all that is expected
  bool playable = false;         ///< an instrument for a player
  std::vector<double> readings;  ///< in the order of `measure_columns`; all finite

  /// The reading called `name` of a run that was judged by `kind`.
  double reading(Playability::Kind judged_by, const std::string& name) const;
  bool operator==(const JudgedRun&) const = default;
};

/// A measure in the tables, plots and JSON of a playability study.
struct MeasureColumn {
  std::string name;  ///< in JSON: "rate_hz"
  std::string head;  ///< "hits/s"
  int digits;        ///< behind the point
  std::string measure;
  bool drawn = false;  ///< over the delay
};
/// All columns of a roll, or of a tone.
const std::vector<MeasureColumn>& measure_columns(Playability::Kind kind);
/// What the columns of `kind` show in a window.
std::vector<double> column_values(Playability::Kind kind, const Window& window);

/// What a run can turn out to be, from best to worst.
struct RunKind {
  std::string name;  ///< "gallop"
  char letter;       ///< on a map of characters
  std::string doc;
};
const std::vector<RunKind>& run_kinds(Playability::Kind kind);

/// Judges what was recorded from `judged.from_s` to the end.
JudgedRun judge(const SceneRecording& recording, const Playability& judged);

}  // namespace tactus
