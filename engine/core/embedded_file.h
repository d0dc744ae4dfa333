#pragma once
// Thread: [any]

#include <string_view>

namespace tactus {

/// A file as it was when the program was built: cmake/embed_files.cmake.
struct EmbeddedFile {
  std::string_view name, bytes;
};

}  // namespace tactus
