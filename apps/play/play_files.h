#pragma once
// Thread: [control]

#include <string>
#include <vector>

#include "apps/play/play_report.h"

namespace tactus::app {

/// What the names of all files of a run begin with.
std::string base_of(const std::string& folder, const PlayedScene& played);

/// The monitor output, the drives and the sensors as a sound file each, unscaled and unclipped; what moved as
/// another, in metres and newtons; the plot. `show`: the two times that it shows; empty: a melody as a whole,
/// otherwise the first second. No empty files. A line each: the path and its contents. Errors: BadFile;
/// OutOfRange for the times.
Result<std::vector<std::string>> write_files(const std::string& folder, const std::vector<std::string>& show,
                                             const PlayedScene& played);

}  // namespace tactus::app
