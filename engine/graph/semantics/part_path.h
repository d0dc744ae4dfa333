#pragma once

// Thread: [control].

#include <filesystem>
#include <string>

#include "engine/core/error.h"
#include "engine/graph/file/source.h"

namespace tactus {

/// Where a path of a graph file leads.
struct PartPath {
  std::string name;                 ///< as messages print it
  std::filesystem::path canonical;  ///< without links and dots: the same file has the same one
};

/// `folder` is the one of the file that names `use`; `root` the folder that must not be left, links resolved.
/// Errors, at `at`: OutOfRange for an absolute path and one that leads out of `root`; BadFile if there is no
/// such file.
Result<PartPath> find_part(const std::string& use, const std::filesystem::path& folder,
                           const std::filesystem::path& root, const Source& at);

/// Links and dots resolved as far as the path exists; "" is the folder we are in.
std::filesystem::path canonical_path(const std::filesystem::path& path);

}  // namespace tactus
