#pragma once

#include <filesystem>

namespace tactus::test {

/// Whether a shipped file needs a library that this build is without.
inline bool is_left_out([[maybe_unused]] const std::filesystem::path& file) {
#if defined(TACTUS_HAS_ODE)
  return false;
#else
  return file.parent_path().filename() == "world";
#endif
}

}  // namespace tactus::test
