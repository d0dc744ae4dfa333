#pragma once

#include <string>
#include <vector>

#include "engine/scene/file/scene_spec.h"
#include "engine/scene/play_scene.h"

namespace tactus {

/// How one run of a scene was to play. docs/playability.md says why it is judged so.
struct JudgedRun {
  std::string kind;              ///< one of `run_kinds`
  double score = 0;              ///< 0 nothing, 1 all that is wanted
  bool playable = false;         ///< an instrument for a player
  std::vector<double> readings;  ///< in the order of `reading_types`; all finite

  /// The reading called `name` of a run that was judged by `kind`.
  double reading(Playability::Kind judged_by, const std::string& name) const;
  bool operator==(const JudgedRun&) const = default;
};

/// A number that a run is judged by.
struct ReadingType {
  std::string name;  ///< "rate_hz"
  std::string head;  ///< of a column of a table: "hits/s"
  int digits;        ///< behind the point
  std::string doc;
  bool drawn = false;  ///< over the delay
};
/// [any] All that are read of a roll, or of a tone.
const std::vector<ReadingType>& reading_types(Playability::Kind kind);

/// What a run can turn out to be, from best to worst.
struct RunKind {
  std::string name;  ///< "gallop"
  char letter;       ///< on a map of characters
  std::string doc;
};
const std::vector<RunKind>& run_kinds(Playability::Kind kind);

/// [control] Judges what was recorded from `judged.from_s` to the end.
JudgedRun judge(const SceneRecording& recording, const Playability& judged);

}  // namespace tactus
