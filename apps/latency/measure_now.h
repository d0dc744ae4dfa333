#pragma once
// Thread: [control]

#include <optional>

#include "apps/latency/loop_options.h"

namespace tactus::app {

/// Measures with a bar on stderr. Errors: of `measure`. Nothing: the user ended it (after
/// install_signal_handlers); the stream is closed.
Result<std::optional<Measurement>> measure_now(Backend& backend, const MeasureSettings& settings);

/// "jack:system, 48 kHz, 64 frames a block, 2 periods; output 1 to input 1"
std::string source_in_words(const MeasureSettings& settings, const StreamGranted& granted);

}  // namespace tactus::app
