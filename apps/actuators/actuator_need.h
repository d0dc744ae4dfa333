#pragma once
// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "apps/actuators/actuator_files.h"
#include "engine/graph/semantics/interval.h"

namespace tactus::app {

/// What an actuator must have: SI, of a price US $.
struct Need {
  std::optional<double> force, excursion, resolution, price;
  std::optional<Interval> band;

  bool any() const { return force || excursion || resolution || price || band; }
};

/// As the options of the command line have it; empty: not asked for.
struct NeedOptions {
  std::string force, band, excursion, resolution, price;
};
/// Throws a CommandError.
Need need_of(const NeedOptions& options);

/// Whether an actuator has it, and what could not be compared.
struct Match {
  std::vector<std::string> lacks, unknown, remarks;
};
Match match(const Actuator& actuator, const Need& need);

}  // namespace tactus::app
