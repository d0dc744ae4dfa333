#pragma once

// Thread: [control].

#include <functional>
#include <string>
#include <vector>

#include "engine/study/stability/stability.h"
#include "engine/study/stability/stability_extremes.h"

namespace tactus {

/// What `tactus check` finds: what the analysis predicts, and what the engine did when it played.
struct StabilityReport {
  StabilityVerdict verdict;
  std::vector<ExtremeRun> runs;  ///< none: the analysis alone

  /// Unstable, too, if a run was not as predicted.
  Stability stability() const;
};

/// What is being done, and the share done.
using StabilityProgress = std::function<void(const std::string& what, double share)>;

/// [control] `quick`: no runs; `workers`: threads for them, 0: one per core. Errors: of the graph.
Checked<StabilityReport> check_stability(const StabilitySubject& subject, const StabilityOptions& options,
                                         bool quick, const StabilityProgress& progress = {}, int workers = 0);

}  // namespace tactus
