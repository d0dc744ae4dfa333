#pragma once

namespace tactus::app {

/// As `project(VERSION)` of CMakeLists.txt has it.
inline constexpr const char* kVersion = "tactus " TACTUS_VERSION;

}  // namespace tactus::app
