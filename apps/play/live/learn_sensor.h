#pragma once
// Thread: [control]

#include <string>

#include "backends/backend.h"
#include "engine/graph/file/spec.h"
#include "engine/rig/rig.h"

namespace tactus::app {

/// [control] Asks the user to hit softly five times, listens to the sensor at `input` ("*": the first one of
/// the instrument that the rig joins to a channel) with nothing driven, and puts what it learnt into the rig.
/// Errors: of the device; UnknownName for the input; of SensorLearner::result, for instance after a minute
/// without five hits.
Status learn_sensitivity(Rig& rig, const GraphSpec& instrument, const std::string& input, Backend& backend,
                         StreamRequest request);

}  // namespace tactus::app
