#pragma once

// Thread: [control]

#include <optional>
#include <vector>

#include "engine/graph/file/field.h"
#include "engine/graph/file/mistakes.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

std::vector<Gesture> read_gestures(const Value::Table& scene, Mistakes& mistakes);
Converters read_converters(const Value::Table& scene, Mistakes& mistakes);
std::vector<Expectation> read_expectations(const Value::Table& scene, Seconds duration, Mistakes& mistakes);
std::optional<Comparison> read_comparison(const Value::Table& scene, Mistakes& mistakes);

}  // namespace tactus
