#pragma once
// Thread: [control]

#include <CLI/CLI.hpp>
#include <filesystem>

#include "engine/core/error.h"

namespace tactus::app {

/// Whether a file can be written there, or files into that folder, which may still be missing. Leaves
/// everything as it was. To be asked before the work whose result goes there. Errors: BadFile.
Status can_write_file(const std::filesystem::path& file);
Status can_write_into(const std::filesystem::path& folder);

/// The same of an option, when the command line is read.
CLI::Validator writable_file();
CLI::Validator writable_folder();

}  // namespace tactus::app
