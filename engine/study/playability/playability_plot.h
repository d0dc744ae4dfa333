#pragma once

#include <filesystem>

#include "engine/study/playability/playability.h"

namespace tactus {

/// [control] A complete study as a picture. Nothing swept besides the delay: score, kind and the main
/// measures, over the delay. One quantity: maps of kind, score and the main reading over delay and quantity.
/// Two: a map of the kind over both, for up to twelve delays. Errors: BadFile.
[[nodiscard]] Status write_picture(const std::filesystem::path& path, const PlayabilityStudy& study);

}  // namespace tactus
