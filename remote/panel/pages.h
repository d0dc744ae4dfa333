#pragma once
// Thread: [any]

#include <span>

#include "engine/core/embedded_file.h"

namespace tactus {

/// The files of remote/panel/web and of uPlot, by their names: "main.js".
std::span<const EmbeddedFile> panel_pages();

}  // namespace tactus
