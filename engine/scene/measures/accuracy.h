#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/graph/file/mistakes.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// Something whose error `tactus study work-precision` tells, by the name that [accuracy] uses.
struct AccuracyType {
  static constexpr auto kUnitOfSubject = "=of";
  std::string name;
  std::string unit;   ///< of `exact`; or kUnitOfSubject
  std::string scale;  ///< unit of `scale`, likewise
  bool may_be_exact;  ///< a number that theory can tell
  std::string doc;
};
/// [any] All of them.
const std::vector<AccuracyType>& accuracy_types();
/// [any] nullptr if there is none of that name.
const AccuracyType* find_accuracy(std::string_view name);

/// `[accuracy]` of a scene: what of it must come out right.
///   rebound = { measure = "speed", of = "plant.stick", from = "2 ms", to = "3 ms", exact = "1 m/s" }
std::vector<Accuracy> read_accuracy(const Value::Table& scene, Seconds duration, Mistakes& mistakes);

}  // namespace tactus
