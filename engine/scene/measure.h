#pragma once

#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/scene/events.h"
#include "engine/scene/play_scene.h"

namespace tactus {

/// Something that can be asked of a recording, by the name that [expect] uses.
struct MeasureType {
  std::string name;
  std::string unit;
  std::string doc;
};
/// [any] All of them.
const std::vector<MeasureType>& measure_types();

/// [control] Of a recording, between two times. Where events are asked for, `of` is a trigger of the
/// instrument
/// ("instrument.hit") or a contact force ("plant.contact": its strikes). Errors: UnknownName, Missing.
Result<double> measure(const SceneRecording& recording, const Expectation& expectation);

/// What came of one line of [expect].
struct Outcome {
  std::string name, measure;
  double value = 0;
  std::string unit;
  bool holds = false;
  std::string wanted;  ///< "at least 15 Hz"
};
/// [control] All mistakes of [expect] in one go.
Checked<std::vector<Outcome>> check_expectations(const SceneSpec& scene, const SceneRecording& recording);

/// The instrument's strikes on what it plays: pushes of a contact force above 5 N; less than 5 ms apart they
/// are one.
std::vector<Strike> strikes_of(const SceneRecording& recording, const std::string& contact = "plant.contact");
/// Times of the first trigger called `name` ("instrument.hit", with or without its output); empty if there is
/// none.
std::vector<double> triggers_of(const SceneRecording& recording, const std::string& name);

}  // namespace tactus
