#pragma once

// Thread: [control].

#include <span>
#include <string>
#include <string_view>

#include "export/kernel_texts.h"

namespace tactus {

/// Files of export/targets that exported programs get, as they were when Tactus was built.
std::span<const KernelFile> target_files();

/// The text of one, by its path in the source tree.
inline std::string target_text(std::string_view path) {
  for (const auto& file : target_files())
    if (file.path == path) return std::string{file.text};
  return {};
}

}  // namespace tactus
