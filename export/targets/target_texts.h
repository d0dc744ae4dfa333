#pragma once

// Thread: [control].

#include <span>
#include <string>
#include <string_view>

#include "engine/core/embedded_file.h"
#include "engine/core/named.h"

namespace tactus {

/// Files of export/targets that exported programs get, as they were when Tactus was built.
std::span<const EmbeddedFile> target_files();

/// The text of one, by its path in the source tree.
inline std::string target_text(std::string_view path) {
  const auto files = target_files();
  const auto* file = find_named(files, path);
  return file == nullptr ? std::string{} : std::string{file->bytes};
}

}  // namespace tactus
