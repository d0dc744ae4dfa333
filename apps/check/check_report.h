#pragma once
// Thread: [control]

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/study/stability/stability.h"
#include "engine/study/stability/stability_extremes.h"

namespace tactus::app {

/// What `tactus check` found.
struct CheckReport {
  std::string name;
  std::string delay_source;  ///< where the delay comes from
  StabilityVerdict verdict;
  std::vector<ExtremeRun> runs;

  /// It is stable, and every run was as predicted.
  bool passed() const {
    return verdict.stable &&
           std::all_of(runs.begin(), runs.end(), [](const auto& run) { return run.as_expected(); });
  }
};

/// Every number of it.
nlohmann::ordered_json json_of(const CheckReport& report);
/// The verdict, what fails, and with `verbose` every table.
void print(const CheckReport& report, bool verbose);

}  // namespace tactus::app
