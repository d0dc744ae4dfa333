#include "engine/study/playability/judged_run.h"

#include <algorithm>

#include "engine/study/playability/judged_roll.h"
#include "engine/study/playability/judged_tone.h"

namespace tactus {

double JudgedRun::reading(Playability::Kind judged_by, const std::string& name) const {
  const auto& types = reading_types(judged_by);
  const auto found =
      std::find_if(types.begin(), types.end(), [&](const ReadingType& type) { return type.name == name; });
  return readings.at(static_cast<std::size_t>(found - types.begin()));
}

const std::vector<ReadingType>& reading_types(Playability::Kind kind) {
  return kind == Playability::Kind::Roll ? roll_readings() : tone_readings();
}

const std::vector<RunKind>& run_kinds(Playability::Kind kind) {
  return kind == Playability::Kind::Roll ? roll_kinds() : tone_kinds();
}

JudgedRun judge(const SceneRecording& recording, const Playability& judged) {
  return judged.kind == Playability::Kind::Roll ? judge_roll(recording, judged)
                                                : judge_tone(recording, judged);
}

}  // namespace tactus
