#pragma once
// Thread: [control]

#include <filesystem>
#include <string>

#include "engine/core/error.h"

namespace tactus {

/// Errors: BadFile.
Status write_file(const std::filesystem::path& file, const std::string& text);
/// The same, but whole or not at all: other programs read the former text or this one. Errors: BadFile.
Status replace_file(const std::filesystem::path& file, const std::string& text);
/// The same; a file that was there before gets the ending "~".
Status replace_file_with_backup(const std::filesystem::path& file, const std::string& text);

}  // namespace tactus
