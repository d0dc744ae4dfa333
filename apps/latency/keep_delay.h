#pragma once
// Thread: [control]

#include <filesystem>

#include "engine/core/error.h"
#include "engine/rig/rig.h"
#include "latency/measured.h"
#include "latency/measurement.h"

namespace tactus::app {

/// What was granted, as the key of a delay.
DelayKey key_of(const StreamGranted& granted);

/// [control] Writes a measured delay where `tactus devices` and `tactus play` look for it. Errors: BadFile.
Status keep_on_machine(const Measurement& measurement);

/// [control] The same into a rig; what the file was stays beside it with a "~". The setting that was left to
/// the card is written too: with another one the delay would not hold. Errors: BadFile.
Status keep_in_rig(const Measurement& measurement, Rig rig, const std::filesystem::path& file);

}  // namespace tactus::app
