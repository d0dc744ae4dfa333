#pragma once

#include <string>
#include <vector>

#include "engine/guard/guarded.h"
#include "latency/measurement.h"
#include "latency/probe/probe_player.h"

namespace tactus {

/// [any] The one that comes first in the order of Verdict; Ok if there is no other.
Finding first_of(const std::vector<Finding>& findings);

/// [control] Why one opening is unreliable, apart from its recording: how it ended, what the guard
/// did (`events`), what the driver counted while the sweeps were played, and whether it kept its word.
std::vector<Finding> stream_findings(const ProbePlayer& player, const StreamGranted& granted,
                                     const std::vector<GuardEvent>& events, int input, bool drive);

/// [control] What all openings say together: the first finding against any of them; frames that were lost in
/// fewer than half of them are only reported when at least three others agree.
void conclude(Measurement& measurement);

/// [control] Where a second arrival comes from: `again` was opened with another block. Empty: that cannot be
/// told.
std::string second_arrival(const Opening& before, const Opening& again);

}  // namespace tactus
