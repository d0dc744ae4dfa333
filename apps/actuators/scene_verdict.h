#pragma once
// Thread: [control]

#include <optional>
#include <string>
#include <vector>

#include "apps/actuators/actuator_files.h"
#include "apps/actuators/scene_demand.h"

namespace tactus::app {

/// Why an actuator does not render a scene, what is within the uncertainty of its figures, and what was not
/// compared.
struct Verdict {
  std::vector<std::string> against, close, open;

  /// "renders it", or why not.
  std::string text() const;
};
Verdict compare(const Actuator& actuator, const Demand& demand);

/// What the drives of a scene without a sensor do to the actuators that it names. Nothing: one of them is
/// not known.
std::optional<double> force_on_case(const std::vector<Actuator>& all, const Demand& demand);

}  // namespace tactus::app
