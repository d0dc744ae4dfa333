#pragma once

// Thread: [control]

#include <nlohmann/json.hpp>
#include <string>

#include "engine/study/stability/stability.h"
#include "engine/study/stability/stability_extremes.h"

namespace tactus::app {

/// What `tactus check` was asked to look at.
struct CheckedSubject {
  std::string name;
  std::string delay_from;  ///< where the delay comes from, in words
};

/// The verdict, and every run as predicted.
bool holds(const StabilityVerdict& verdict, const std::vector<ExtremeRun>& runs);
/// Every number of it.
nlohmann::ordered_json to_json(const CheckedSubject& subject, const StabilityVerdict& verdict,
                               const std::vector<ExtremeRun>& runs);
/// The verdict, what fails, and with `verbose` every table.
void print(const CheckedSubject& subject, const StabilityVerdict& verdict,
           const std::vector<ExtremeRun>& runs, bool verbose);

}  // namespace tactus::app
