#pragma once

#include <string>

#include "engine/core/error.h"
#include "latency/path_profile.h"

namespace tactus::app {

/// [control] A path's profile as JSON: format, sample_rate_hz, low_hz, high_hz, taps. Errors: BadFile.
Status write_profile(const std::string& file, const PathProfile& profile);
/// Errors besides: BadFile if it is not for `sample_rate`.
Result<PathProfile> read_profile(const std::string& file, Hertz sample_rate);

}  // namespace tactus::app
