#pragma once
// Thread: [control]

#include <filesystem>
#include <vector>

#include "apps/play/live/performer.h"
#include "apps/play/live/remote/live_scope.h"
#include "remote/picture.h"

namespace tactus::app {

/// The graphs of a performer and the limits of its outputs, without what the device has granted and without
/// the text of its files.
Picture make_picture(Performer& performer, const LiveScope& scope);

/// The text of each file that can be read.
std::vector<PictureFile> read_files(const std::vector<std::filesystem::path>& files);

}  // namespace tactus::app
