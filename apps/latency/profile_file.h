#pragma once

#include <filesystem>
#include <string>

#include "engine/core/error.h"
#include "latency/calibration.h"

namespace tactus::app {

/// [control] The profile as a graph that scenes can use (engine/scene/file/path_file.h), with what was found,
/// and of which device, in words. Errors: BadFile.
Status write_profile(const std::filesystem::path& file, const Calibration& calibration,
                     const std::string& device);
/// [control] The profile of such a file at `sample_rate`, whatever it was measured at. Errors: the first of
/// the file.
Result<PathProfile> read_profile(const std::filesystem::path& file, Hertz sample_rate);

}  // namespace tactus::app
