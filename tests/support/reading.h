#pragma once

#include <string>

#include "engine/core/named.h"
#include "engine/scene/measures/playability_result.h"

namespace tactus::test {

/// The reading in the column `name` of a run that was evaluated as `kind`.
inline double reading(const PlayabilityResult& run, Playability::Kind kind, const std::string& name) {
  const auto& columns = measure_columns(kind);
  return run.readings.at(static_cast<std::size_t>(find_named(columns, name) - columns.data()));
}

}  // namespace tactus::test
