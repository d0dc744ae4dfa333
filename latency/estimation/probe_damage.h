#pragma once
// Thread: [control]

#include <optional>
#include <vector>

#include "latency/estimation/analysis.h"
#include "latency/estimation/probe_windows.h"

namespace tactus {

/// Where probes are not as the others are.
struct ProbeDamage {
  std::vector<DelayStep> steps;  ///< other frames in place of those that were played, or lost within a probe
  bool overdriven = false;  ///< at the same place of two probes the same: loud and soft ones differ there

  /// [control] `probes` as they are in time, with the gains of `tracked`; `variance`: of a frame of noise.
  /// What sounds beside a probe is none. Frames that are lost within a probe move those behind it; `ends`: of
  /// the first and the last one nothing else shows it.
  static ProbeDamage of(const std::vector<ProbeInTime>& probes, const std::vector<TrackedProbe>& tracked,
                        double variance, std::int64_t longest, bool ends);
};

/// [control] Frames that were lost or repeated within a probe, of at most 64: where its parts before and
/// behind a place have different delays, one of them the expected one, and that explains most of what a
/// single delay does not.
std::optional<DelayStep> step_within(const ProbeInTime& probe, double variance);

}  // namespace tactus
