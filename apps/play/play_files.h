#pragma once

// Thread: [control]

#include <string>
#include <vector>

#include "apps/play/play_report.h"

namespace tactus::app {

/// Where the files of a run go, and what the picture shows.
struct PlayFiles {
  std::string folder = "out";
  std::vector<std::string> show;  ///< two times; empty: a melody as a whole, of the rest the first second
};

/// What all files of a run begin with.
std::string base_of(const PlayFiles& files, const PlayedScene& played);

/// What is heard, the drives and the sensors as a sound file each, unscaled and unclipped; what moved as
/// another, in metres and newtons; the picture. No empty files. A line each: the path and its
/// contents. Errors: BadFile; OutOfRange for the times.
Result<std::vector<std::string>> write_files(const PlayFiles& files, const PlayedScene& played);

}  // namespace tactus::app
