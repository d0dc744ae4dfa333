#pragma once
// Thread: [control]

#include <string>
#include <vector>

#include "apps/actuators/actuator_files.h"
#include "apps/cli/json.h"

namespace tactus::app {

/// [any] To the three digits that are printed.
double three_digits(double si);
/// [any] "2.6 mm", with three digits.
std::string number_text(double si, const char* unit);

/// [control] The figures of actuators as a table.
void print_table(const std::vector<const Actuator*>& actuators);
/// Each figure in words, and where it comes from.
void print_sources(const Actuator& actuator);
Json json_of(const ActuatorFigures& figures);

}  // namespace tactus::app
